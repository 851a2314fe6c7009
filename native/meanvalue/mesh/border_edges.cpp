#include "meanvalue/mesh/border_edges.h"

#include <algorithm>
#include <cstdint>

#include "meanvalue/common/errors.h"

namespace meanvalue {

std::vector<std::pair<Index, Index>> border_edges(Index count, const std::vector<Index>& corners,
                                                  const std::vector<Index>& starts, const Execution& execution) {
    for (const Index v : corners) {
        if (v < 0 || v >= count) throw InvalidInput(message("a corner is ", v, ", none of the ", count, " vertices"));
    }
    std::vector<Index> ends(corners.size());  // of the edges that begin at corners
    auto end = static_cast<Index>(corners.size());
    for (std::size_t face = starts.size(); face-- > 0; end = starts[face]) {
        execution.check_every(face);
        if (starts[face] < 0 || starts[face] > end) {
            throw InvalidInput(message("starts do not ascend from 0 to the count of corners, ", corners.size()));
        }
        for (Index k = starts[face]; k < end; ++k)
            ends[k] = corners[k + 1 < end ? k + 1 : starts[face]];
    }
    const auto mark = [](Index v) {  // numbers of which no few add up to 0
        std::uint64_t mixed = (static_cast<std::uint64_t>(v) + 1) * 0x9e3779b97f4a7c15;
        mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9;
        return mixed ^ (mixed >> 27);
    };
    // Two faces at an edge that look to one side cancel out. What is left to be sorted is little.
    std::vector<std::uint64_t> sums(static_cast<std::size_t>(count), 0);
    const auto first = static_cast<std::size_t>(starts.empty() ? end : starts[0]);
    for (std::size_t k = first; k < corners.size(); ++k) {
        sums[corners[k]] += mark(ends[k]);
        sums[ends[k]] -= mark(corners[k]);
    }
    std::vector<std::pair<Index, Index>> edges, alone;
    for (std::size_t k = first; k < corners.size(); ++k) {
        if (sums[corners[k]] != 0 && sums[ends[k]] != 0 && corners[k] != ends[k])
            edges.emplace_back(std::minmax({corners[k], ends[k]}));
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t k = 0; k < edges.size(); ++k) {
        const bool is_shared =
            (k > 0 && edges[k - 1] == edges[k]) || (k + 1 < edges.size() && edges[k + 1] == edges[k]);
        if (!is_shared) alone.push_back(edges[k]);
    }
    return alone;
}

}  // namespace meanvalue
