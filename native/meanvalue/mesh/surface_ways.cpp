#include "meanvalue/mesh/surface_ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <queue>

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

SurfaceWays::SurfaceWays(Positions positions, const EdgesView& edges, const TrianglesView& triangles, double gap,
                         int threads, const Execution& execution)
    : positions_(std::move(positions)) {
    const auto count = static_cast<Index>(positions_.rows());
    steps_.offsets.assign(count + 1, 0);
    for (Index e = 0; e < edges.rows(); ++e) {
        execution.check_every(e);
        if (edges.row(e).minCoeff() < 0 || edges.row(e).maxCoeff() >= count) {
            throw InvalidInput(message("edge ", e, " is between vertices ", edges(e, 0), " and ", edges(e, 1),
                                       ", but there are ", count));
        }
    }
    neighbours_ = grouped<Index>(count, [&](const auto& visit) {
        for (Index e = 0; e < edges.rows(); ++e) {
            visit(edges(e, 0), edges(e, 1));
            visit(edges(e, 1), edges(e, 0));
        }
    });
    DisjointSets parts(count);  // by their vertices, which mostly lie together: edges come in any order
    part_of_.reserve(count);
    for (Index v = 0; v < count; ++v) {
        for (const Index neighbour : neighbours_.of(v)) {
            if (neighbour < v) parts.join(neighbour, v);
        }
    }
    for (Index v = 0; v < count; ++v)
        part_of_.push_back(parts.root(v));
    if (triangles.rows() == 0) return;
    if (triangles.minCoeff() < 0 || triangles.maxCoeff() >= count) {
        throw InvalidInput(message("a triangle has a corner that is none of the ", count, " vertices"));
    }
    const Index part = part_of_[triangles(0, 0)];
    bool is_one = true;
    for (Index e = 0; e < edges.rows(); ++e)
        is_one = is_one && part_of_[edges(e, 0)] == part;
    if (!is_one) find_steps(edges, triangles, gap, threads, execution);
}

/// Where a vertex is near to another piece, and where an edge is that is longer than the gap is wide: an end may go
/// deep into what it belongs to.
void SurfaceWays::find_steps(const EdgesView& edges, const TrianglesView& triangles, double gap, int threads,
                             const Execution& execution) {
    const TriangleTree tree(positions_, triangles, part_of_, execution);
    const auto count = static_cast<Index>(positions_.rows());
    std::vector<std::vector<Step>> found(piece_count(count) + piece_count(static_cast<Index>(edges.rows())));
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
            for (const Index neighbour : neighbours_.of(v))
                shortest = std::min(shortest, (positions_.row(neighbour) - positions_.row(v)).norm());
            if (shortest < kInfinite) look(found[piece], {v}, positions_.row(v), std::max(gap, kNearEdge * shortest));
        }
    });
    const Index before = piece_count(count);
    parallel_pieces(static_cast<Index>(edges.rows()), threads, execution, [&](Index piece, Index begin, Index end) {
        for (Index e = begin; e < end; ++e) {
            const Index a = edges(e, 0), b = edges(e, 1);
            const Vector3 from = positions_.row(a);
            const Vector3 along = Vector3(positions_.row(b)) - from;
            const bool is_long = gap > 0.0 && along.norm() > 2.0 * gap && along.allFinite();
            const double places = is_long ? std::min(kMostPlaces, std::ceil(along.norm() / (2.0 * gap))) : 0.0;
            for (double k = 1.0; k < places; ++k)
                look(found[before + piece], {a, b}, from + k / places * along, gap);
        }
    });
    steps_ = grouped<Step>(count, [&](const auto& visit) {
        for (const std::vector<Step>& some : found) {
            for (const Step& step : some)
                visit(step.from, step);
        }
    });
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
    std::vector<Eigen::Vector3f> gaps(steps_.items.empty() ? 0 : count,
                                      Eigen::Vector3f::Zero());  // that were stepped over
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
        for (const Index to : neighbours_.of(v)) {
            if (!(way < along[to])) continue;  // no way through here is shorter: half of the lengths are not needed
            if (reach(to, (positions_.row(to) - positions_.row(v)).norm()) && !gaps.empty()) gaps[to] = gaps[v];
        }
        for (const Step& step : steps_.of(v)) {
            if (reach(step.to, step.length)) gaps[step.to] = gaps[v] + step.gap;
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
        for (const Index neighbour : neighbours_.of(seed)) {
            const double length = (positions_.row(neighbour) - positions_.row(seed)).norm();
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
        for (const Index neighbour : neighbours_.of(v)) {
            if (group[neighbour] < 0) group[neighbour] = group[v];
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
            for (const Index neighbour : neighbours_.of(v)) {
                const Index other = group[neighbour];
                if (std::exchange(seen[other], number) != number) result.neighbours_.items.push_back(other);
            }
            for (const Step& step : steps_.of(v))
                result.steps_.items.push_back({number, group[step.to], step.length, step.gap});
        };
        take(middle);
        for (const Index neighbour : neighbours_.of(middle))
            take(neighbour);
        result.neighbours_.offsets.push_back(static_cast<std::int64_t>(result.neighbours_.items.size()));
        result.steps_.offsets.push_back(static_cast<std::int64_t>(result.steps_.items.size()));
        result.part_of_.push_back(group[part_of_[middle]]);
    }
    return result;
}

double SurfaceWays::limb_within(Index vertex, const std::vector<double>& distances, double least,
                                double limit) const {
    double first = std::max(least, kFirstLevel * limit);
    for (const Index neighbour : neighbours_.of(vertex))
        first = std::max(first, kFirstEdges * (positions_.row(neighbour) - positions_.row(vertex)).norm());
    std::vector<double> levels;
    for (double level = first; level < limit && levels.size() < kMostLevels; level *= kLevelStep)
        levels.push_back(level);
    std::vector<std::vector<std::pair<Index, Index>>> crossed(levels.size());  // edges, from the near end to the far
    for (Index v = 0; v < static_cast<Index>(distances.size()); ++v) {
        if (distances[v] == kInfinite) continue;
        const auto next = std::lower_bound(levels.begin(), levels.end(), distances[v]);
        for (const Index neighbour : neighbours_.of(v)) {
            const double far = distances[neighbour];
            for (auto level = next; level != levels.end() && *level < far; ++level) {
                crossed[level - levels.begin()].emplace_back(v, neighbour);
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
        for (const Index neighbour : neighbours_.of(v)) {
            if (place[neighbour] >= 0) lines.join(place[v], place[neighbour]);
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
