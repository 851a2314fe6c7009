// Computes the mean-value encoding of a whole mesh: paper, section 2.1.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// Encodes every vertex by its ring (equations 1 to 9), with the fallback rules of docs/algorithm.md where the
/// formulas break down; each vertex that needed one is listed in Encoding::guarded.
/// @param positions n x 3 rest positions, finite, any units.
/// @param threads as given by thread_count(); the result is the same for any number.
/// @param with_cotangents whether these are kept, which no solver reads.
/// @throws Cancelled. Cost: linear; see docs/benchmarks.md.
Encoding encode(const OneRings& rings, const PositionsView& positions, int threads, Execution& execution,
                bool with_cotangents = false);

}  // namespace meanvalue
