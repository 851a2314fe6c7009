// Which fixed vertices may be removed from coarse levels, and what they may be merged into.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// The fixed vertices in connected parts: neighbors of one handle.
struct FixedParts {
    std::vector<Index> part;       ///< n: number of the part; -1 for free vertices
    std::vector<char> is_extreme;  ///< n: is never removed
};

/// @param handles n numbers, or empty where all fixed vertices are of one handle.
/// Up to four extreme vertices of each part are chosen: the farthest from its middle, the farthest from that, the
/// farthest from the line through both, and the farthest from those three. So a part keeps its extent, a part of up
/// to four vertices all of them, and one that is not on a line determines rotations as before.
/// Cost: linear.
FixedParts find_fixed_parts(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                            const std::vector<Index>& handles);

}  // namespace meanvalue
