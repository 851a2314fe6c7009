#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>

#include "meanvalue/encoding/encoder.h"

namespace meanvalue {

void Hierarchy::split(int coarse, int fine, Positions& positions, int threads, const Execution& execution) const {
    for (int level = coarse; level > fine; --level)
        levels[level].splits.apply(positions, threads, execution);
}

void Hierarchy::carry(int coarse, int fine, const PositionsView& rest, Positions& positions, int threads,
                      const Execution& execution) const {
    for (int level = coarse; level > fine; --level)
        levels[level].splits.carry(rest, positions, threads, execution);
}

Index Hierarchy::longest_ring() const {
    Index longest = 0;
    for (const Level& level : levels)
        longest = std::max({longest, level.encoding.longest_ring(), level.splits.longest_ring()});
    return longest;
}

std::size_t Hierarchy::bytes() const {
    std::size_t sum = order.capacity() * sizeof(Index) + soft_merges.capacity() * sizeof(SoftMerge);
    for (const Level& level : levels)
        sum += level.encoding.bytes() + level.splits.bytes();
    return sum;
}

Hierarchy encode_along(RemovalOrder order, const PositionsView& positions, SplitBy split_by, int threads,
                       Execution& execution) {
    Hierarchy hierarchy;
    for (RemovalLevel& removal : order.levels) {
        Level level{removal.removed_count, removal.free_count, encode(removal.rings, positions, threads, execution),
                    std::move(removal.splits)};
        if (split_by == SplitBy::kEncoding) level.splits.encode(positions, threads, execution);
        hierarchy.levels.push_back(std::move(level));
    }
    hierarchy.order = std::move(order.order);
    hierarchy.soft_merges = std::move(order.soft_merges);
    hierarchy.base_unknowns = std::move(order.base_unknowns);
    return hierarchy;
}

}  // namespace meanvalue
