// Weighted averages of encodings: paper, section 4.3.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"

namespace meanvalue {

/// Averages the coefficients of equation 13: w_ij, whose sums stay one, and the factors of |v'_i - v'_j|; row i by
/// the weights of vertex i. A ring that is steep in one shape has the steep form. One shape alone gives its encoding,
/// to rounding.
/// @param encodings one or more with the same rings. @return `guarded` is that of the first. The same bits for any
/// `threads`.
/// @throws InvalidInput that names the first vertex with other rings; Cancelled.
Encoding blend(const std::vector<const Encoding*>& encodings, const ShapeWeights& weights, int threads,
               const Execution& execution);

}  // namespace meanvalue
