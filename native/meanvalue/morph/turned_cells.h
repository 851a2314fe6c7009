// The cells of several shapes, turned onto each other, and how each of them is turned: what in-between shapes are
// made of.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/fast/rest_cells.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/morph/turn_relations.h"

namespace meanvalue {

/// A cell is a vertex with the edges of its ring (RestCells). In shape k that of vertex i has the edges
///     size_k G_k M_ijk e_ijk,
/// size_k being the root mean square of all edges, G_k the turn of the shape as a whole, and M_ijk the rotation
/// half-way from that of cell i to that of cell j, so that a cell that is bent has its edges bent as well. The cells'
/// rotations turn the edges of one shape onto those of the others as well as possible; in the mean of all shapes they
/// are none. An in-between shape has averages of the e_ijk and rotations by TurnRelations (docs/algorithm.md,
/// "Blending"); it does not depend on which shape is the first.
class TurnedCells {
  public:
    /// @param layout of the rings of all shapes. @param shapes one or more, n x 3 each. The same bits for any
    /// `threads`. @throws Cancelled. Cost: linear, but for a queue of all cells.
    TurnedCells(const Encoding& layout, const std::vector<PositionsView>& shapes, int threads,
                const Execution& execution);

    Index shape_count() const { return shape_count_; }
    /// The cells of an in-between shape, and how each of them is turned: by TurnRelations.
    /// @param sizes of the in-between shape over that of each: see common_sizes(). @param frames a rotation for each
    /// shape, which all its cells are turned by first; or none. @param turn which all cells are turned by at last.
    /// @param rotations receives n. @param cells receives their edges, |ring|, each in the cell's own frame.
    void fill(const ShapeWeights& weights, const std::vector<double>& sizes, const std::vector<Quaternion>& frames,
              const Quaternion& turn, int threads, const Execution& execution, std::vector<Quaternion>& rotations,
              RestCells& cells) const;

    const std::vector<double>& sizes() const { return sizes_; }
    /// The geometric mean of all sizes over each of them.
    std::vector<double> common_sizes(const std::vector<double>& weights) const;
    /// G_k.
    const Quaternion& whole(std::size_t shape) const { return wholes_[shape]; }
    /// The average of the G_k.
    Quaternion whole_turn(const std::vector<double>& weights) const;
    /// How some cells are turned in space, with the same weights for all. @return one for each of `vertices`.
    std::vector<Quaternion> turns(const std::vector<double>& weights, const std::vector<Index>& vertices,
                                  const Execution& execution) const;
    /// Of an in-between shape, the same way. @param values one for each shape, above 0.
    static double geometric_mean(const std::vector<double>& values, const double* weights);

    std::size_t bytes() const;

  private:
    struct Turns;  // of all cells in each shape, while they are sought

    Turns align_cells(const std::vector<PositionsView>& shapes, int threads, const Execution& execution);
    void find_turns(Turns& turns, int threads, const Execution& execution);
    std::size_t middle_of(const Turns& turns, Index stride, const Execution& execution) const;
    void find_wholes(const Turns& turns, Index stride, const Execution& execution);
    Matrix3 turn_of(const Turns& turns, Index vertex, std::size_t shape) const;
    void centre_cells(Turns& turns, Index stride, int threads, const Execution& execution) const;
    Index turned_to(Index vertex, Index neighbour) const;
    void bend_back(const Turns& turns, int threads, const Execution& execution);

    Index shape_count_;
    const Encoding& layout_;
    std::vector<Vector3> edges_;      // for each half-edge e_ijk of one shape after another
    std::vector<double> sizes_;       // of each shape
    std::vector<Quaternion> wholes_;  // G_k
    std::optional<TurnRelations> relations_;
};

}  // namespace meanvalue
