#include "meanvalue/mesh/border_edges.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/mesh/disjoint_sets.h"
#include "meanvalue/mesh/same_places.h"

namespace meanvalue {

std::vector<std::pair<Index, Index>> border_edges(Index count, const std::vector<Index>& corners,
                                                  const std::vector<Index>& starts, const Execution& execution) {
    for (const Index v : corners) {
        if (v < 0 || v >= count) throw InvalidInput(message("a corner is ", v, ", none of the ", count, " vertices"));
    }
    const auto mark = [](Index v) {  // numbers of which no few add up to 0
        std::uint64_t mixed = (static_cast<std::uint64_t>(v) + 1) * 0x9e3779b97f4a7c15;
        mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9;
        return mixed ^ (mixed >> 27);
    };
    // Two faces at an edge that look to one side cancel out. What is left to be sorted is little.
    std::vector<std::uint64_t> sums(static_cast<std::size_t>(count), 0);
    const auto for_each_edge = [&](const auto& visit) {
        auto end = static_cast<Index>(corners.size());
        for (std::size_t face = starts.size(); face-- > 0; end = starts[face]) {
            execution.check_every(face);
            if (starts[face] < 0 || starts[face] > end) {
                throw InvalidInput(message("starts do not ascend from 0 to the count of corners, ", corners.size()));
            }
            for (Index k = starts[face]; k < end; ++k)
                visit(corners[k], corners[k + 1 < end ? k + 1 : starts[face]]);
        }
    };
    for_each_edge([&](Index a, Index b) {
        sums[a] += mark(b);
        sums[b] -= mark(a);
    });
    std::vector<std::pair<Index, Index>> edges, alone;
    if (std::count(sums.begin(), sums.end(), 0) == count) return alone;
    for_each_edge([&](Index a, Index b) {
        if (sums[a] != 0 && sums[b] != 0 && a != b) edges.emplace_back(std::minmax(a, b));
    });
    std::sort(edges.begin(), edges.end());
    for (std::size_t k = 0; k < edges.size(); ++k) {
        const bool is_shared =
            (k > 0 && edges[k - 1] == edges[k]) || (k + 1 < edges.size() && edges[k + 1] == edges[k]);
        if (!is_shared) alone.push_back(edges[k]);
    }
    return alone;
}

std::vector<Index> first_of_seams(const PositionsView& points, const std::vector<Index>& corners,
                                  const std::vector<Index>& starts, double distance, const Execution& execution) {
    enum Mark : char { kNone, kBorder, kJoined, kBeside };
    const auto count = static_cast<Index>(points.rows()), size = static_cast<Index>(corners.size());
    std::vector<Mark> marks(points.rows(), kNone);
    for (const auto& [low, high] : border_edges(count, corners, starts, execution))
        marks[low] = marks[high] = kBorder;
    std::vector<Index> own(points.rows());
    std::iota(own.begin(), own.end(), 0);
    const auto first_of_some = [&](Mark mark) {
        std::vector<Index> some, places = own;
        std::copy_if(own.begin(), own.end(), std::back_inserter(some), [&](Index v) { return marks[v] == mark; });
        Positions chosen(some.size(), 3);
        for (std::size_t k = 0; k < some.size(); ++k)
            chosen.row(k) = points.row(some[k]);
        const std::vector<Index> found = first_of_place(chosen, distance, execution);
        for (std::size_t k = 0; k < some.size(); ++k)
            places[some[k]] = some[found[k]];
        return places;
    };
    std::vector<Index> first = first_of_some(kBorder);
    if (first == own) return own;
    for (const Index v : own) {
        if (first[v] != v) marks[v] = marks[first[v]] = kJoined;
    }
    const auto for_each_face = [&](const auto& visit) {
        for (std::size_t f = 0; f < starts.size(); ++f)
            visit(corners.data() + starts[f], corners.data() + (f + 1 < starts.size() ? starts[f + 1] : size));
    };
    for_each_face([&](const Index* begin, const Index* end) {
        if (std::none_of(begin, end, [&](Index v) { return marks[v] == kJoined; })) return;
        for (const Index* v = begin; v != end; ++v)
            marks[*v] = marks[*v] == kJoined ? kJoined : kBeside;
    });
    // Where no two surfaces go on together there is no double, and what follows would take long.
    if (first_of_some(kBeside) == own) return first;
    const std::vector<Index> place = first_of_place(points, distance, execution);
    std::vector<Index> counts(own.size(), 0);
    for (const Index v : place)
        ++counts[v];
    DisjointSets pieces(count);
    for_each_face([&](const Index* begin, const Index* end) {
        for (const Index* v = begin; v != end; ++v)
            pieces.join(*begin, *v);
    });
    constexpr char kAtBorder = 1, kPartlyAlone = 2;  // a double is at a border alone
    std::vector<char> found(own.size(), 0);          // of pieces
    for (const Index v : own)
        found[pieces.root(v)] |= (marks[v] == kJoined ? kAtBorder : 0) | (counts[place[v]] == 1 ? kPartlyAlone : 0);
    std::vector<Index> kept = own;  // of places: the lowest vertex, if there is one, that is no double's
    for (Index v = count; v-- > 0;) {
        if (found[pieces.root(v)] == kAtBorder) {
            counts[place[v]] = 0;
        } else {
            kept[place[v]] = v;
        }
    }
    for (const Index v : own)
        first[v] = counts[place[v]] == 0 ? kept[place[v]] : first[v];
    return first;
}

}  // namespace meanvalue
