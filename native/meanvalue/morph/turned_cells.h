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
///     size_k G_k exp(omega_ik) e_ijk,
/// size_k being the root mean square of all edges, G_k the turn of the shape as a whole, omega_ik the rotation vector
/// of the cell, and e_ijk turned onto each other by the best rotations. The omega_ik of one cell sum to zero, and go
/// evenly from each cell to the next, however far they turn in all. An in-between shape has averages of each
/// (docs/algorithm.md, "Blending"); it does not depend on which shape is the first.
class TurnedCells {
  public:
    /// @param layout of the rings of all shapes. @param shapes one or more, n x 3 each. The same bits for any
    /// `threads`. @throws Cancelled. Cost: linear, but for a queue of all cells.
    TurnedCells(const Encoding& layout, const std::vector<PositionsView>& shapes, int threads,
                const Execution& execution);

    Index shape_count() const { return shape_count_; }
    /// The average cells.
    /// @param sizes of the in-between shape over that of each: see common_sizes(). @param cells receives them,
    /// |ring|.
    void fill_edges(const ShapeWeights& weights, const std::vector<double>& sizes, int threads,
                    const Execution& execution, RestCells& cells) const;
    /// How each of these is turned in the in-between shape, but for the turn of the whole: averages in space,
    /// corrected by TurnRelations.
    /// @param frames a rotation for each shape, which all its cells are turned by first; or none.
    /// @param rotations receives n.
    void fill_rotations(const ShapeWeights& weights, const std::vector<Matrix3>& frames, int threads,
                        const Execution& execution, std::vector<Matrix3>& rotations) const;

    const std::vector<double>& sizes() const { return sizes_; }
    /// The geometric mean of all sizes over each of them.
    std::vector<double> common_sizes(const std::vector<double>& weights) const;
    /// G_k.
    const Matrix3& whole(std::size_t shape) const { return wholes_[shape]; }
    /// The average of the G_k.
    Matrix3 whole_turn(const std::vector<double>& weights) const;
    /// Of an in-between shape, the same way. @param values one for each shape, above 0.
    static double geometric_mean(const std::vector<double>& values, const double* weights);

    std::size_t bytes() const;

  private:
    struct Turns;  // of all cells in each shape, while they are sought

    Turns align_cells(const std::vector<PositionsView>& shapes, int threads, const Execution& execution);
    void find_turns(Turns& turns, int threads, const Execution& execution);
    void follow_turns(const Turns& turns, const Execution& execution);

    Index shape_count_;
    const Encoding& layout_;
    std::vector<Vector3> edges_;   // for each half-edge e_ijk of one shape after another
    std::vector<Vector3> turns_;   // for each vertex omega_ik in the same way
    std::vector<double> sizes_;    // of each shape
    std::vector<Matrix3> wholes_;  // G_k
    std::optional<TurnRelations> relations_;
};

}  // namespace meanvalue
