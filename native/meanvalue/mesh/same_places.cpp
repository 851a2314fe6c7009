#include "meanvalue/mesh/same_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

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

}  // namespace meanvalue
