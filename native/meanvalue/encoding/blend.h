// Weighted averages of encodings: paper, section 4.3.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"

namespace meanvalue {

/// Averages weights w_ij as they are, since their sums stay one, and instead of the cotangents b_ij their angles,
/// which are bounded (docs/algorithm.md, "Blending"); row i by the weights of vertex i. At one shape alone it is the
/// encoding of that to rounding.
/// @param encodings one or more of the same layout, as encode_alike() makes them. The same bits for any `threads`.
/// @throws InvalidInput that names the first vertex where the layouts differ; Cancelled.
Encoding blend(const std::vector<const Encoding*>& encodings, const ShapeWeights& weights, int threads,
               const Execution& execution);

}  // namespace meanvalue
