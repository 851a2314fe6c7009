// Weighted averages of encodings: paper, section 4.3.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"

namespace meanvalue {

/// Averages the weights w_ij, whose sums stay one, and the angles of the cotangents b_ij, which are bounded
/// (docs/algorithm.md, "Blending"); row i by the weights of vertex i. One shape alone gives its encoding, to
/// rounding.
/// @param encodings one or more of the same layout, as encode_alike() makes them. The same bits for any `threads`.
/// @throws InvalidInput that names the first vertex where the layouts differ; Cancelled.
Encoding blend(const std::vector<const Encoding*>& encodings, const ShapeWeights& weights, int threads,
               const Execution& execution);

}  // namespace meanvalue
