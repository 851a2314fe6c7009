// How several shapes of one mesh are put over each other before they are mixed.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/morph/relative_rotations.h"

namespace meanvalue {

/// A cell is a vertex with the edges of its ring. In shape k that of vertex i has the edges
///     size_k G_k R_ik M_ijk e_ijk,
/// size_k being the root mean square of its edges over that of the central shape's, alike ones before others, G_k the
/// rotation of the shape as a whole, R_ik that of the cell in it, and M_ijk the rotation half-way on from there to
/// that of cell j, so that a cell that is bent has its edges bent as well. Rotations are those that take the edges of
/// the central shape onto those of the others as well as possible. An in-between shape has averages of the e_ijk and
/// rotations by RelativeRotations (docs/algorithm.md, "Blending"); it does not depend on the order of the shapes.
class LocalCells {
  public:
    /// @param rings of all shapes. @param shapes one or more, n x 3 each. The same bits for any `threads`.
    /// @pre rings outlive it. @throws Cancelled. Cost: linear in n; k (k - 1) / 2 passes over all cells for k shapes.
    LocalCells(const OneRings& rings, const std::vector<PositionsView>& shapes, int threads,
               const Execution& execution);

    /// The cells of an in-between shape.
    /// @param sizes of the in-between shape over that of each: see common_sizes(). @param frames a rotation for each
    /// shape, which all its cells are rotated by first; or none. @param rotation of all cells at last.
    /// @param rotations receives n. @param edges receives those of all rings, each in its cell's own frame.
    void fill(const ShapeWeights& weights, const std::vector<double>& sizes, const std::vector<Quaternion>& frames,
              const Quaternion& rotation, int threads, const Execution& execution, std::vector<Quaternion>& rotations,
              std::vector<Vector3>& edges) const;

    /// The geometric mean of all sizes over each of them.
    std::vector<double> common_sizes(const std::vector<double>& weights) const;
    /// G_k.
    const Quaternion& shape_rotation(std::size_t shape) const { return shape_rotations_[shape]; }
    /// The average of the G_k.
    Quaternion mean_rotation(const std::vector<double>& weights) const {
        return mean_of_rotations(shape_rotations_, weights);
    }

  private:
    void measure_sizes(const std::vector<PositionsView>& shapes, std::size_t central, const Execution& execution);
    std::vector<Quaternion> rotations_against(const std::vector<PositionsView>& shapes, std::size_t reference,
                                              int threads, const Execution& execution) const;
    std::size_t central_shape(const std::vector<PositionsView>& shapes, const std::vector<Quaternion>& rotations,
                              const Execution& execution) const;
    void measure_edges(const std::vector<PositionsView>& shapes, const std::vector<Quaternion>& rotations,
                       int threads, const Execution& execution);

    const OneRings& rings_;
    std::size_t count_;                        // of shapes
    std::vector<Vector3> edges_;               // for each half-edge size_k e_ijk of one shape after another
    std::vector<double> sizes_;                // of each shape
    std::vector<Quaternion> shape_rotations_;  // G_k
    std::optional<RelativeRotations> relative_;
};

/// Weight, beside 1, of a vertex that moves or is all graft when the result is placed: the less, the less the body
/// rocks because an arm swings; at 0 a part of which nothing is still would have no place.
constexpr double kLeastWeight = 1e-3;

/// Shapes that the whole is a mix of are put about their centers, at their common size; shapes that enter in part
/// (grafts) by what fits best where they enter.
struct ShapeOverlay {
    std::vector<Similarity> places;    ///< of each shape
    std::vector<double> sizes;         ///< see LocalCells::fill()
    std::vector<Quaternion> frames;    ///< see LocalCells::fill()
    Quaternion rotation;               ///< of the whole
    std::vector<double> whole_shares;  ///< n: how much of each vertex is no graft, above 0; or empty: all of all
};

/// @param parts as MorphOptions::parts. @throws InvalidInput where these are no shapes, or all of them; Cancelled.
ShapeOverlay overlay_shapes(const std::vector<PositionsView>& shapes, const OneRings& rings, const LocalCells& cells,
                            const ShapeWeights& weights, const std::optional<std::vector<Index>>& parts,
                            const Execution& execution);

/// The average shape by positions alone. @return n x 3.
Positions linear_blend(const std::vector<PositionsView>& shapes, const ShapeWeights& weights,
                       const ShapeOverlay& overlay, int threads, const Execution& execution);

}  // namespace meanvalue
