#include "meanvalue/mesh/surface_ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <queue>
#include <tuple>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/mesh/disjoint_sets.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// How much longer than straight over the faces a way along edges is on a grid of squares.
const double kMostDetour = std::sqrt(2.0);

/// Pieces that are no farther apart than this share of the shortest edge at a vertex nearly touch there.
constexpr double kNearEdge = 0.5;

/// What is free reaches over so many edges at least.
constexpr double kLeastEdges = 2.5;

/// An edge is looked at in so many places at most, however small the gap is.
constexpr double kMostPlaces = 1024.0;

/// Lines of equal distance are looked at from this share of the limit on, and from so many times the longest edge at
/// the vertex; each is so much farther than the one before.
constexpr double kFirstLevel = 0.02, kFirstEdges = 2.0, kLevelStep = 1.06;
constexpr std::size_t kMostLevels = 100;  // more than there are, but for limits near 0

/// A limb is so many times as long as its widest ring, which is measured from its middle. Where this has become as
/// much less as kLost, it was a limb that ended where it began to be less than kKept: thighs grow wide slowly.
constexpr double kLeastLength = 2.05, kLost = 0.85, kKept = 0.92;

/// So many vertices tell a limb from the body; a group of one with its neighbors has about so many.
constexpr std::ptrdiff_t kEnough = 20000, kOfGroup = 4;

}  // namespace

SurfaceWays::SurfaceWays(Positions positions, const Edges& edges, const TrianglesView& triangles, double gap,
                         int threads, const Execution& execution)
    : positions_(std::move(positions)) {
    const auto count = static_cast<Index>(positions_.rows());
    DisjointSets parts(count);
    first_neighbour_.assign(count + 1, 0);
    for (std::size_t e = 0; e < edges.size(); ++e) {
        execution.check_every(e);
        const auto [a, b] = edges[e];
        if (std::min(a, b) < 0 || std::max(a, b) >= count) {
            throw InvalidInput(
                message("edge ", e, " is between vertices ", a, " and ", b, ", but there are ", count));
        }
        parts.join(a, b);
        ++first_neighbour_[a + 1];
        ++first_neighbour_[b + 1];
    }
    for (Index v = 0; v < count; ++v) {
        part_of_.push_back(parts.root(v));
        first_neighbour_[v + 1] += first_neighbour_[v];
    }
    neighbours_.resize(2 * edges.size());
    std::vector<std::size_t> next(first_neighbour_.begin(), first_neighbour_.end() - 1);
    for (const auto& [a, b] : edges) {
        neighbours_[next[a]++] = b;
        neighbours_[next[b]++] = a;
    }
    first_step_.assign(count + 1, 0);
    if (triangles.rows() == 0) return;
    if (triangles.minCoeff() < 0 || triangles.maxCoeff() >= count) {
        throw InvalidInput(message("a triangle has a corner that is none of the ", count, " vertices"));
    }
    const Index part = part_of_[triangles(0, 0)];
    const auto is_other = [&](const auto& edge) { return part_of_[edge.first] != part; };
    if (std::any_of(edges.begin(), edges.end(), is_other)) find_steps(edges, triangles, gap, threads, execution);
}

/// Where a vertex is near to another piece, and where an edge is that is longer than the gap is wide: an end may go
/// deep into what it belongs to.
void SurfaceWays::find_steps(const Edges& edges, const TrianglesView& triangles, double gap, int threads,
                             const Execution& execution) {
    const TriangleTree tree(positions_, triangles, part_of_, execution);
    const auto count = static_cast<Index>(positions_.rows());
    std::vector<std::vector<Step>> found(piece_count(count) + piece_count(static_cast<Index>(edges.size())));
    const auto look = [&](std::vector<Step>& into, std::initializer_list<Index> from, const Vector3& at,
                          double reach) {
        if (!at.allFinite()) return;
        const TriangleTree::Place place = tree.nearest({at, part_of_[*from.begin()]}, reach);
        if (place.triangle < 0) return;
        const Eigen::Vector3f step = (place.point - at).cast<float>();
        for (const Index a : from) {
            for (const Index b : tree.triangles().row(place.triangle)) {
                const double length =
                    (Vector3(positions_.row(a)) - at).norm() + (Vector3(positions_.row(b)) - place.point).norm();
                into.push_back({a, b, static_cast<float>(length), step});
                into.push_back({b, a, static_cast<float>(length), -step});
            }
        }
    };
    parallel_pieces(count, threads, execution, [&](Index piece, Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            double shortest = kInfinite;
            for (std::size_t k = first_neighbour_[v]; k < first_neighbour_[v + 1]; ++k) {
                shortest = std::min(shortest, (positions_.row(neighbours_[k]) - positions_.row(v)).norm());
            }
            if (shortest < kInfinite) look(found[piece], {v}, positions_.row(v), std::max(gap, kNearEdge * shortest));
        }
    });
    const Index before = piece_count(count);
    parallel_pieces(static_cast<Index>(edges.size()), threads, execution, [&](Index piece, Index begin, Index end) {
        for (Index e = begin; e < end; ++e) {
            const auto [a, b] = edges[e];
            const Vector3 from = positions_.row(a);
            const Vector3 along = Vector3(positions_.row(b)) - from;
            const bool is_long = gap > 0.0 && along.norm() > 2.0 * gap && along.allFinite();
            const double places = is_long ? std::min(kMostPlaces, std::ceil(along.norm() / (2.0 * gap))) : 0.0;
            for (double k = 1.0; k < places; ++k)
                look(found[before + piece], {a, b}, from + k / places * along, gap);
        }
    });
    for (const std::vector<Step>& some : found) {
        for (const Step& step : some)
            ++first_step_[step.from + 1];
    }
    for (Index v = 0; v < count; ++v)
        first_step_[v + 1] += first_step_[v];
    steps_.resize(first_step_.back());
    std::vector<std::size_t> next(first_step_.begin(), first_step_.end() - 1);
    for (const std::vector<Step>& some : found) {
        for (const Step& step : some)
            steps_[next[step.from]++] = step;
    }
}

std::vector<double> SurfaceWays::distances(const std::vector<Index>& seeds, double limit) const {
    std::vector<double> result = reach(seeds, limit);
    std::vector<char> is_whole(result.size(), 1);  // of pieces, by their lowest vertex
    for (const Index seed : seeds)
        is_whole[part_of_[seed]] = 0;
    for (std::size_t v = 0; v < result.size(); ++v) {
        if (result[v] == kInfinite) is_whole[part_of_[v]] = 0;
    }
    for (std::size_t v = 0; v < result.size(); ++v) {
        if (is_whole[part_of_[v]]) result[v] = -1.0;
    }
    return result;
}

/// As distances(), without a word of whole pieces.
std::vector<double> SurfaceWays::reach(const std::vector<Index>& seeds, double limit) const {
    const std::size_t count = part_of_.size();
    std::vector<double> along(count, kInfinite);
    std::vector<Index> origin(count, -1);
    std::vector<Eigen::Vector3f> gaps(steps_.empty() ? 0 : count, Eigen::Vector3f::Zero());  // that were stepped over
    using Way = std::pair<double, Index>;
    std::priority_queue<Way, std::vector<Way>, std::greater<>> queue;
    require_vertices(seeds);
    for (const Index seed : seeds) {
        along[seed] = 0.0;
        origin[seed] = seed;
        queue.emplace(0.0, seed);
    }
    std::vector<double> result(count, kInfinite);
    while (!queue.empty()) {
        const double way = queue.top().first;
        const Index v = queue.top().second;
        queue.pop();
        if (way > along[v]) continue;
        const auto reach = [&](Index to, double length) {
            if (!(way + length < along[to]) || way + length > kMostDetour * limit) return false;
            along[to] = way + length;
            origin[to] = origin[v];
            queue.emplace(along[to], to);
            return true;
        };
        for (std::size_t k = first_neighbour_[v]; k < first_neighbour_[v + 1]; ++k) {
            const Index to = neighbours_[k];
            if (reach(to, (positions_.row(to) - positions_.row(v)).norm()) && !gaps.empty()) gaps[to] = gaps[v];
        }
        for (std::size_t k = first_step_[v]; k < first_step_[v + 1]; ++k) {
            if (reach(steps_[k].to, steps_[k].length)) gaps[steps_[k].to] = gaps[v] + steps_[k].gap;
        }
        Vector3 straight = positions_.row(v) - positions_.row(origin[v]);
        if (!gaps.empty()) straight -= gaps[v].cast<double>();
        const double distance = std::max(straight.norm(), way / kMostDetour);
        if (distance <= limit) result[v] = distance;
    }
    return result;
}

std::vector<double> SurfaceWays::falloff(const std::vector<Index>& seeds, double limit, double free) const {
    require_vertices(seeds);
    for (const Index seed : seeds) {
        for (std::size_t k = first_neighbour_[seed]; k < first_neighbour_[seed + 1]; ++k) {
            const double length = (positions_.row(neighbours_[k]) - positions_.row(seed)).norm();
            if (std::isfinite(length)) limit = std::max(limit, kLeastEdges * length);
        }
    }
    std::vector<double> weights = distances(seeds, limit);
    for (double& each : weights) {
        // In this order what is no number, as 0 / 0, is 1.
        const double t = std::max(0.0, std::min(1.0, (limit - each) / ((1.0 - free) * limit)));
        each = t * t * (3.0 - 2.0 * t);
    }
    return weights;
}

void SurfaceWays::require_vertices(const std::vector<Index>& seeds) const {
    for (const Index seed : seeds) {
        if (seed < 0 || static_cast<std::size_t>(seed) >= part_of_.size()) {
            throw InvalidInput(message("seed ", seed, " is none of the ", part_of_.size(), " vertices"));
        }
    }
}

double SurfaceWays::limb(Index vertex, double least, double limit) const {
    std::optional<SurfaceWays> coarse;
    for (const double share : {0.125, 0.25, 0.5, 1.0}) {
        const SurfaceWays& ways = coarse ? *coarse : *this;
        const std::vector<double> distances = ways.reach({vertex}, share * limit);
        const double found = ways.limb_within(vertex, distances, least, share * limit);
        if (found > 0.0) return found;
        const auto unreached = std::count(distances.begin(), distances.end(), kInfinite);
        for (auto count = static_cast<std::ptrdiff_t>(distances.size()) - unreached; count > kEnough;
             count /= kOfGroup)
            coarse = (coarse ? *coarse : *this).coarser(vertex);
    }
    return 0.0;
}

/// The same of groups of a vertex and its neighbors, which stand where that vertex is. @param vertex becomes the
/// number of its group.
SurfaceWays SurfaceWays::coarser(Index& vertex) const {
    std::vector<Index> group(part_of_.size(), -1), middles;
    for (Index v = 0; v < static_cast<Index>(group.size()); ++v) {
        if (group[v] >= 0) continue;
        group[v] = static_cast<Index>(middles.size());
        for (std::size_t n = first_neighbour_[v]; n < first_neighbour_[v + 1]; ++n) {
            if (group[neighbours_[n]] < 0) group[neighbours_[n]] = group[v];
        }
        middles.push_back(v);
    }
    vertex = group[vertex];
    SurfaceWays result;
    result.positions_ = positions_(middles, Eigen::all);
    std::vector<Index> seen(middles.size(), -1);
    for (const Index middle : middles) {
        const Index number = seen[group[middle]] = group[middle];
        const auto take = [&](Index v) {
            if (group[v] != number) return;
            for (std::size_t n = first_neighbour_[v]; n < first_neighbour_[v + 1]; ++n) {
                const Index other = group[neighbours_[n]];
                if (std::exchange(seen[other], number) != number) result.neighbours_.push_back(other);
            }
            for (std::size_t n = first_step_[v]; n < first_step_[v + 1]; ++n)
                result.steps_.push_back({number, group[steps_[n].to], steps_[n].length, steps_[n].gap});
        };
        result.first_neighbour_.push_back(result.neighbours_.size());
        result.first_step_.push_back(result.steps_.size());
        result.part_of_.push_back(group[part_of_[middle]]);
        take(middle);
        for (std::size_t n = first_neighbour_[middle]; n < first_neighbour_[middle + 1]; ++n)
            take(neighbours_[n]);
    }
    result.first_neighbour_.push_back(result.neighbours_.size());
    result.first_step_.push_back(result.steps_.size());
    return result;
}

double SurfaceWays::limb_within(Index vertex, const std::vector<double>& distances, double least,
                                double limit) const {
    double first = std::max(least, kFirstLevel * limit);
    for (std::size_t k = first_neighbour_[vertex]; k < first_neighbour_[vertex + 1]; ++k) {
        first = std::max(first, kFirstEdges * (positions_.row(neighbours_[k]) - positions_.row(vertex)).norm());
    }
    std::vector<double> levels;
    for (double level = first; level < limit && levels.size() < kMostLevels; level *= kLevelStep)
        levels.push_back(level);
    std::vector<std::vector<std::pair<Index, Index>>> crossed(levels.size());  // edges, from the near end to the far
    for (Index v = 0; v < static_cast<Index>(distances.size()); ++v) {
        if (distances[v] == kInfinite) continue;
        const auto next = std::lower_bound(levels.begin(), levels.end(), distances[v]);
        for (std::size_t k = first_neighbour_[v]; k < first_neighbour_[v + 1]; ++k) {
            const double far = distances[neighbours_[k]];
            for (auto level = next; level != levels.end() && *level < far; ++level) {
                crossed[level - levels.begin()].emplace_back(v, neighbours_[k]);
            }
        }
    }
    std::vector<Index> place(distances.size(), -1);
    double widest = 0.0, longest = 0.0, end = 0.0;
    for (std::size_t k = 0; k < levels.size(); ++k) {
        widest = std::max(widest, widest_ring(crossed[k], distances, levels[k], place));
        if (widest == 0.0) continue;
        const double length = levels[k] / widest;
        if (longest >= kLeastLength && length < kLost * longest) return end;
        longest = std::max(longest, length);
        if (length >= kKept * longest) end = levels[k];
    }
    return 0.0;
}

/// Of the connected lines where distances are `level`: the most that one is wide, in the root of the mean square from
/// its middle, in the piece where this is least: the hem of wide trousers is no body. @param place n, -1 before and
/// after.
double SurfaceWays::widest_ring(const std::vector<std::pair<Index, Index>>& crossed,
                                const std::vector<double>& distances, double level, std::vector<Index>& place) const {
    std::vector<Index> ends;
    for (const auto& [near, far] : crossed) {
        for (const Index v : {near, far}) {
            if (place[v] >= 0) continue;
            place[v] = static_cast<Index>(ends.size());
            ends.push_back(v);
        }
    }
    DisjointSets lines(static_cast<Index>(ends.size()));
    for (const Index v : ends) {
        for (std::size_t k = first_neighbour_[v]; k < first_neighbour_[v + 1]; ++k) {
            if (place[neighbours_[k]] >= 0) lines.join(place[v], place[neighbours_[k]]);
        }
    }
    std::vector<Vector3> sums(ends.size(), Vector3::Zero());
    std::vector<double> squares(ends.size(), 0.0), counts(ends.size(), 0.0);
    for (const auto& [near, far] : crossed) {
        // An end beyond the limit has no distance: 0, at the near one.
        const double share = (level - distances[near]) / (distances[far] - distances[near]);
        const Vector3 at = positions_.row(near) + share * (positions_.row(far) - positions_.row(near));
        if (!at.allFinite()) continue;
        const Index line = lines.root(place[near]);
        sums[line] += at;
        squares[line] += at.squaredNorm();
        ++counts[line];
    }
    std::map<Index, double> widest;  // of each piece
    for (std::size_t line = 0; line < ends.size(); ++line) {
        if (counts[line] == 0.0) continue;
        const double square = squares[line] / counts[line] - (sums[line] / counts[line]).squaredNorm();
        double& of_piece = widest[part_of_[ends[line]]];
        of_piece = std::max(of_piece, std::sqrt(std::max(square, 0.0)));
    }
    for (const Index v : ends)
        place[v] = -1;
    const auto is_less = [](const auto& one, const auto& other) { return one.second < other.second; };
    return widest.empty() ? 0.0 : std::min_element(widest.begin(), widest.end(), is_less)->second;
}

}  // namespace meanvalue
