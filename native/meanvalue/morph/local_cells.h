// The cells of several shapes in local frames, and the rotations of these frames: what in-between shapes are made of.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/morph/relative_rotations.h"

namespace meanvalue {

/// A cell is a vertex with the edges of its ring (RestCells). In shape k that of vertex i has the edges
///     size_k G_k M_ijk e_ijk,
/// size_k being the root mean square of all edges, G_k the rotation of the shape as a whole, and M_ijk the rotation
/// half-way from that of cell i to that of cell j, so that a cell that is bent has its edges bent as well. The cells'
/// rotations take the edges of one shape onto those of the others as well as possible; their mean over all shapes is
/// the identity. An in-between shape has averages of the e_ijk and rotations by RelativeRotations (docs/algorithm.md,
/// "Blending"); it does not depend on which shape is the first.
class LocalCells {
  public:
    /// @param layout of the rings of all shapes. @param shapes one or more, n x 3 each. The same bits for any
    /// `threads`. @throws Cancelled. Cost: linear, but for a queue of all cells.
    LocalCells(const Encoding& layout, const std::vector<PositionsView>& shapes, int threads,
               const Execution& execution);

    Index shape_count() const { return shape_count_; }
    /// The cells of an in-between shape.
    /// @param sizes of the in-between shape over that of each: see common_sizes(). @param frames a rotation for each
    /// shape, which all its cells are rotated by first; or none. @param rotation of all cells at last.
    /// @param rotations receives n. @param cells receives their edges, |ring|, each in the cell's own frame.
    void fill(const ShapeWeights& weights, const std::vector<double>& sizes, const std::vector<Quaternion>& frames,
              const Quaternion& rotation, int threads, const Execution& execution, std::vector<Quaternion>& rotations,
              RestCells& cells) const;

    /// The geometric mean of all sizes over each of them.
    std::vector<double> common_sizes(const std::vector<double>& weights) const;
    /// G_k.
    const Quaternion& shape_rotation(std::size_t shape) const { return shape_rotations_[shape]; }
    /// The average of the G_k.
    Quaternion mean_rotation(const std::vector<double>& weights) const;
    /// The rotations of some cells in space, with the same weights for all. @return one for each of `vertices`.
    std::vector<Quaternion> rotations(const std::vector<double>& weights, const std::vector<Index>& vertices,
                                      const Execution& execution) const;

  private:
    struct Search;

    Index shape_count_;
    const Encoding& layout_;
    std::vector<Vector3> edges_;               // for each half-edge e_ijk of one shape after another
    std::vector<double> sizes_;                // of each shape
    std::vector<Quaternion> shape_rotations_;  // G_k
    std::optional<RelativeRotations> relative_;
};

}  // namespace meanvalue
