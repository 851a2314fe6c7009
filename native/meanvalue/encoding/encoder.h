// Computes the mean-value encoding of a whole mesh: paper, section 2.1.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// Encodes every vertex by its ring (equations 1 to 9), with the fallback rules of docs/algorithm.md where the
/// formulas break down; each vertex that needed one is listed in Encoding::guarded.
/// @param positions n x 3 rest positions, finite, any units.
/// @param threads as given by thread_count(); the result is the same for any number.
/// @throws Cancelled. Cost: linear; see docs/benchmarks.md.
Encoding encode(const OneRings& rings, const PositionsView& positions, int threads, Execution& execution);

/// Several shapes of one mesh in one layout, so that their encodings may be averaged: a vertex whose ring one shape
/// has flat or steep has the fallback in all of them, and one that a shape can't be encoded at in none.
/// @param shapes at least one, n x 3 each. @return as many; their `guarded` is the same.
std::vector<Encoding> encode_alike(const OneRings& rings, const std::vector<PositionsView>& shapes, int threads,
                                   Execution& execution);

}  // namespace meanvalue
