// How several shapes of one mesh are put over each other before they are mixed.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/morph/local_cells.h"

namespace meanvalue {

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
