#include "meanvalue/mesh/same_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

using Cell = std::array<std::int64_t, 3>;

/// Of the extent of all points: cells smaller than this could not be told from each other.
constexpr double kLeastCell = 1e-12;

/// Of more points than these in one cell only the outermost are compared with those of others.
constexpr std::size_t kCrowd = 8;

/// All points of a cell of this share of the distance are within it: less than the square root of a third.
constexpr double kWithin = 0.577;

/// A direction that neither edges nor planes of modeled meshes are at right angles to: along it they do not pile up.
const Vector3 kAlong(0.5377, 0.3141, 0.7824);

struct Grid {
    Vector3 low;
    double side;

    Cell cell(const Vector3& point, double shift = 0.0) const {
        Cell found;
        for (int axis = 0; axis < 3; ++axis)
            found[axis] = static_cast<std::int64_t>(std::floor((point[axis] - low[axis]) / side + shift));
        return found;
    }
};

/// Points in the order of their cells, and of their numbers within one.
std::vector<std::pair<Cell, Index>> sorted(const Grid& grid, const PositionsView& points,
                                           const std::vector<Index>& numbers) {
    std::vector<std::pair<Cell, Index>> result;
    result.reserve(numbers.size());
    for (const Index v : numbers)
        result.emplace_back(grid.cell(points.row(v)), v);
    std::sort(result.begin(), result.end());
    return result;
}

/// Joins the points of each cell. @return those that stand for theirs, ascending.
std::vector<Index> join_cells(const Grid& grid, const PositionsView& points, const std::vector<Index>& numbers,
                              DisjointSets& places) {
    const auto order = sorted(grid, points, numbers);
    std::vector<Index> stands;
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        std::vector<Index> own;
        for (end = begin; end < order.size() && order[end].first == order[begin].first; ++end) {
            const Index v = order[end].second;
            places.join(order[begin].second, v);
            if (own.size() <= kCrowd && !(end > begin && points.row(v) == points.row(own.back()))) own.push_back(v);
        }
        if (own.size() > kCrowd) {
            own.clear();
            for (int axis = 0; axis < 3; ++axis) {
                const auto is_lower = [&](const auto& a, const auto& b) {
                    return points(a.second, axis) < points(b.second, axis);
                };
                const auto ends = std::minmax_element(order.begin() + static_cast<std::ptrdiff_t>(begin),
                                                      order.begin() + static_cast<std::ptrdiff_t>(end), is_lower);
                own.insert(own.end(), {ends.first->second, ends.second->second});
            }
        }
        stands.insert(stands.end(), own.begin(), own.end());
    }
    std::sort(stands.begin(), stands.end());
    stands.erase(std::unique(stands.begin(), stands.end()), stands.end());
    return stands;
}

/// Those of `numbers` that another one may be near to, by their cells along one direction, for speed.
std::vector<Index> maybe_near(const Grid& grid, const PositionsView& points, const std::vector<Index>& numbers) {
    std::size_t size = 16;
    while (size < 16 * numbers.size())
        size *= 2;
    std::vector<char> counts(size, 0);
    const auto count = [&](std::size_t cell) -> char& { return counts[cell & (size - 1)]; };
    std::vector<std::size_t> cells;
    for (const Index v : numbers) {
        const double along = kAlong.dot(Vector3(points.row(v)) - grid.low) / (1.001 * grid.side);  // rounding
        cells.push_back(static_cast<std::size_t>(along) + 1);
        count(cells.back()) = count(cells.back()) == 0 ? 1 : 2;
    }
    std::vector<Index> found;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        if (count(cells[k] - 1) + count(cells[k]) + count(cells[k] + 1) > 1) found.push_back(numbers[k]);
    }
    return found;
}

}  // namespace

std::vector<Index> first_of_place(const PositionsView& points, double distance, const Execution& execution) {
    if (!(distance >= 0.0) || !std::isfinite(distance)) {
        throw InvalidInput(message("distance is ", distance, "; give one that is at least 0"));
    }
    std::vector<Index> numbers;
    Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (Index v = 0; v < points.rows(); ++v) {
        const Vector3 point = points.row(v);
        if (!point.allFinite()) continue;
        numbers.push_back(v);
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    DisjointSets places(static_cast<Index>(points.rows()));
    if (!numbers.empty()) {
        const double least = std::max(kLeastCell * (high - low).maxCoeff(), 1e-300);
        const Grid along{low, std::max(distance, least)}, grid{low, 2.0 * along.side};
        numbers = maybe_near(along, points, numbers);
        const std::vector<Index> stands =
            join_cells({low, std::max(kWithin * distance, least)}, points, numbers, places);
        execution.check();
        const auto order = sorted(grid, points, maybe_near(along, points, stands));
        for (std::size_t k = 0; k < order.size(); ++k) {  // what is near enough is in one of eight cells
            execution.check_every(k);
            const Vector3 point = points.row(order[k].second);
            const Cell lowest = grid.cell(point, -0.5);
            for (int corner = 0; corner < 8; ++corner) {
                const Cell cell{lowest[0] + (corner & 1), lowest[1] + (corner >> 1 & 1), lowest[2] + (corner >> 2)};
                auto other = std::lower_bound(order.begin(), order.end(), std::make_pair(cell, Index{0}));
                for (; other != order.end() && other->first == cell; ++other) {
                    const double apart = (Vector3(points.row(other->second)) - point).norm();
                    if (apart <= distance) places.join(order[k].second, other->second);
                }
            }
        }
    }
    std::vector<Index> result(static_cast<std::size_t>(points.rows()));
    for (Index v = 0; v < points.rows(); ++v)
        result[v] = places.root(v);
    return result;
}

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
    enum Mark : char { kNone, kInside, kBorder, kJoined, kBeside };
    const auto count = static_cast<Index>(points.rows()), size = static_cast<Index>(corners.size());
    std::vector<Mark> marks(points.rows(), kNone);
    std::vector<double> along;  // of borders, ascending: few others lie there
    for (const auto& [low, high] : border_edges(count, corners, starts, execution)) {
        for (const Index v : {low, high}) {
            marks[v] = kBorder;
            if (points.row(v).allFinite()) along.push_back(kAlong.dot(points.row(v)));
        }
    }
    std::sort(along.begin(), along.end());
    std::vector<Index> own(points.rows());
    std::iota(own.begin(), own.end(), 0);
    if (along.empty()) return own;
    for (const Index v : corners)
        marks[v] = std::max(marks[v], kInside);
    for (const Index v : own) {
        if (marks[v] != kInside) continue;
        const double at = kAlong.dot(points.row(v));
        const auto next = std::lower_bound(along.begin(), along.end(), at - 1.001 * distance);
        if (next == along.end() || *next > at + 1.001 * distance) marks[v] = kNone;
    }
    const auto first_of_some = [&](Mark mark, Mark other) {
        std::vector<Index> some, places = own;
        std::copy_if(own.begin(), own.end(), std::back_inserter(some),
                     [&](Index v) { return marks[v] == mark || marks[v] == other; });
        const std::vector<Index> found = first_of_place(points(some, Eigen::all), distance, execution);
        for (std::size_t k = 0; k < some.size(); ++k)
            places[some[k]] = some[found[k]];
        return places;
    };
    std::vector<Index> first = first_of_some(kBorder, kInside), at(own.size(), -1);  // at: of places, what is joined
    for (Index v = count; v-- > 0;)
        if (marks[v] == kInside) at[first[v]] = v;
    DisjointSets joined(count);
    for (const Index v : own) {
        if (marks[v] != kBorder) continue;
        if (at[first[v]] < 0) at[first[v]] = v;
        joined.join(at[first[v]], v);
    }
    for (const Index v : own)
        first[v] = joined.root(v);
    for (const Index v : own) {
        if (first[v] != v) marks[v] = marks[first[v]] = kJoined;
    }
    if (first == own) return own;
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
    if (first_of_some(kBeside, kBeside) == own) return first;
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
