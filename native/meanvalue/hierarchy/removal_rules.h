// Which vertices may be removed from coarse levels, and what they may be merged into.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// Fixed vertices hang together in parts, neighbors of one handle, and so do soft ones apart from them.
struct RemovalRules {
    std::vector<Index> part;  ///< n: number of the part; -1 for free vertices, and for fixed ones that all stay
    std::vector<char> stays;  ///< n: is never removed

    /// A vertex of a part may only be merged into its own part, or the part would shrink away under free ones.
    bool may_become(Index vertex, Index to) const { return part[vertex] < 0 || part[vertex] == part[to]; }
};

/// Up to four extreme vertices of each part stay: the farthest from its middle, the farthest from that, the farthest
/// from the line through both, and the farthest from those three. So a part keeps its extent, a part of up to four
/// vertices all of them, and one that is not on a line determines rotations as before.
/// Cost: linear.
RemovalRules find_removal_rules(const OneRings& rings, const PositionsView& positions,
                                const std::vector<char>& is_fixed, const CoarseningOptions& options);

}  // namespace meanvalue
