#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/hierarchy/coarsening.h"

namespace meanvalue {

Hierarchy build_hierarchy(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                          const CoarseningOptions& options, int threads, Execution& execution) {
    execution.begin_stage("build hierarchy");
    Hierarchy result;
    Coarsening coarsening(rings, positions, is_fixed, options, threads, execution);
    std::vector<OneRings> level_rings;
    const auto add_level = [&](Index size) {
        coarsening.coarsen_to(size, result.order);
        level_rings.push_back(coarsening.present_rings());
        result.levels.push_back({result.order.size(), coarsening.remaining(), {}, coarsening.take_splits()});
    };
    for (const Index size : options.level_sizes)
        add_level(size);
    if (options.down_to_base || options.level_sizes.empty()) add_level(0);
    result.soft_merges = coarsening.soft_merges();
    for (std::size_t k = 0; k < level_rings.size(); ++k)
        result.levels[k].encoding = encode(level_rings[k], positions, threads, execution);
    return result;
}

Index Hierarchy::longest_ring() const {
    Index longest = 0;
    for (const Level& level : levels)
        longest = std::max({longest, level.encoding.longest_ring(), level.splits.longest_ring()});
    return longest;
}

}  // namespace meanvalue
