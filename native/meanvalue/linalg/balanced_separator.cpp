#include "meanvalue/linalg/balanced_separator.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace meanvalue {
namespace {

// Vertices of a graph that is cut as it is: the flow through it takes longer than linear time.
constexpr Index kSmallGraph = 30000;
// Share of a graph that each of its ends takes, in percent: less lets separators be smaller, and takes longer.
constexpr Index kEndPercent = 40;
// The least share of the vertices on either side of the surroundings of a cut, in percent.
constexpr Index kLeastPercent = 20;

/// In edges, from one vertex.
std::vector<Index> distances(const Graph& graph, Index from, WorkMeter& work) {
    std::vector<Index> distance(graph.size(), -1);
    std::vector<Index> queue = {from};
    distance[from] = 0;
    for (std::size_t k = 0; k < queue.size(); ++k) {
        work.add(1 + graph.degree(queue[k]));
        for (const Index* u = graph.begin(queue[k]); u != graph.end(queue[k]); ++u) {
            if (distance[*u] >= 0) continue;
            distance[*u] = distance[queue[k]] + 1;
            queue.push_back(*u);
        }
    }
    return distance;
}

/// From each of four vertices that are far from each other.
std::array<std::vector<Index>, 4> distances_from_extremes(const Graph& graph, WorkMeter& work) {
    std::array<std::vector<Index>, 4> result;
    std::vector<Index> nearest = distances(graph, 0, work);
    for (std::vector<Index>& distance : result) {
        const auto farthest = std::max_element(nearest.begin(), nearest.end()) - nearest.begin();
        distance = distances(graph, static_cast<Index>(farthest), work);
        if (&distance == &result[0]) nearest = distance;
        for (std::size_t v = 0; v < nearest.size(); ++v)
            nearest[v] = std::min(nearest[v], distance[v]);
    }
    return result;
}

/// The vertices from one end of the graph to the other. The four extremes a, b, c, d are at the ends in one of the
/// ways a | b, ac | bd, ad | bc: that with the fewest vertices of the first half next to the other half.
std::vector<Index> from_end_to_end(const Graph& graph, WorkMeter& work) {
    constexpr Index kWays[3][4] = {{1, -1, 0, 0}, {1, -1, 1, -1}, {1, -1, -1, 1}};
    const std::array<std::vector<Index>, 4> distance = distances_from_extremes(graph, work);
    const Index size = graph.size();
    std::vector<Index> best;
    Index smallest_border = std::numeric_limits<Index>::max();
    for (const auto& way : kWays) {
        std::vector<Index> difference(size, 0);
        for (std::size_t k = 0; k < distance.size(); ++k) {
            for (Index v = 0; v < size; ++v)
                difference[v] += way[k] * distance[k][v];
        }
        std::vector<Index> vertices(size);
        std::iota(vertices.begin(), vertices.end(), 0);
        std::stable_sort(vertices.begin(), vertices.end(),
                         [&](Index a, Index b) { return difference[a] < difference[b]; });
        std::vector<char> is_in_first_half(size, 0);
        for (Index k = 0; k < size / 2; ++k)
            is_in_first_half[vertices[k]] = 1;
        Index border = 0;
        for (Index k = 0; k < size / 2; ++k) {
            const Index v = vertices[k];
            work.add(1 + graph.degree(v));
            border +=
                std::all_of(graph.begin(v), graph.end(v), [&](Index u) { return is_in_first_half[u] != 0; }) ? 0 : 1;
        }
        if (border >= smallest_border) continue;
        smallest_border = border;
        best = std::move(vertices);
    }
    return best;
}

/// The graph of some vertices, numbered in their order; neighbours descending, so that the search for paths goes to
/// the other end first.
Graph graph_of_some(const Graph& graph, const std::vector<Index>& vertices, WorkMeter& work) {
    std::vector<Index> number(graph.size(), -1);
    for (std::size_t k = 0; k < vertices.size(); ++k)
        number[vertices[k]] = static_cast<Index>(k);
    Graph result;
    for (const Index v : vertices) {
        work.add(1 + graph.degree(v));
        const auto degree = std::count_if(graph.begin(v), graph.end(v), [&](Index u) { return number[u] >= 0; });
        result.offsets.push_back(result.offsets.back() + degree);
    }
    result.neighbours.resize(result.offsets.back());
    std::vector<std::int64_t> next(result.offsets.begin(), result.offsets.end() - 1);
    for (Index k = result.size(); k-- > 0;) {
        work.add(1 + graph.degree(vertices[k]));
        for (const Index* u = graph.begin(vertices[k]); u != graph.end(vertices[k]); ++u) {
            if (number[*u] >= 0) result.neighbours[next[number[*u]]++] = k;
        }
    }
    return result;
}

/// By the smallest separator of some vertices, of which the first `left_end` are on the left and those from
/// `right_begin` on on the right.
Cut separate(const Graph& graph, std::vector<Index> vertices, Index left_end, Index right_begin, WorkMeter& work,
             const Execution& execution) {
    Cut cut;
    cut.graph = graph_of_some(graph, vertices, work);
    cut.vertices = std::move(vertices);
    cut.sides = minimum_separator(cut.graph, left_end, right_begin, execution);
    return cut;
}

/// Sets the sides of the vertices that are cut.
void take_sides(const Cut& cut, std::vector<Side>& sides) {
    for (std::size_t k = 0; k < cut.vertices.size(); ++k)
        sides[cut.vertices[k]] = cut.sides[k];
}

/// A vertex of `graph` for each cluster.
struct Clusters {
    std::vector<Index> of;  // each vertex of the whole graph
    Graph graph;
};

/// Each a vertex with those of its neighbours that are in none yet.
Clusters find_clusters(const Graph& graph, WorkMeter& work) {
    Clusters result;
    result.of.assign(graph.size(), -1);
    std::vector<Index> members;  // cluster after cluster
    std::vector<Index> begins;
    for (Index v = 0; v < graph.size(); ++v) {
        if (result.of[v] >= 0) continue;
        const auto cluster = static_cast<Index>(begins.size());
        begins.push_back(static_cast<Index>(members.size()));
        const auto take = [&](Index u) {
            if (result.of[u] >= 0) return;
            result.of[u] = cluster;
            members.push_back(u);
        };
        take(v);
        std::for_each(graph.begin(v), graph.end(v), take);
    }
    begins.push_back(graph.size());
    std::vector<Index> seen_by(begins.size(), -1);
    for (Index cluster = 0; cluster + 1 < static_cast<Index>(begins.size()); ++cluster) {
        seen_by[cluster] = cluster;
        for (Index k = begins[cluster]; k < begins[cluster + 1]; ++k) {
            work.add(2 * (1 + graph.degree(members[k])));
            for (const Index* u = graph.begin(members[k]); u != graph.end(members[k]); ++u) {
                const Index other = result.of[*u];
                if (std::exchange(seen_by[other], cluster) != cluster) result.graph.neighbours.push_back(other);
            }
        }
        result.graph.offsets.push_back(static_cast<std::int64_t>(result.graph.neighbours.size()));
    }
    return result;
}

/// The smallest separator in and around the clusters between the sides.
/// @return whether enough was left on both sides; else `sides` are of no use.
bool separate_near(const Clusters& clusters, const std::vector<Side>& cluster_sides, const Graph& graph,
                   std::vector<Side>& sides, WorkMeter& work, const Execution& execution) {
    std::vector<char> is_near(cluster_sides.size(), 0);
    for (Index cluster = 0; cluster < clusters.graph.size(); ++cluster) {
        if (cluster_sides[cluster] != Side::kBetween) continue;
        is_near[cluster] = 1;
        std::for_each(clusters.graph.begin(cluster), clusters.graph.end(cluster),
                      [&](Index other) { is_near[other] = 1; });
    }
    std::vector<Index> near;
    for (Index v = 0; v < graph.size(); ++v) {
        sides[v] = cluster_sides[clusters.of[v]];
        if (is_near[clusters.of[v]] != 0) {
            sides[v] = Side::kBetween;
            near.push_back(v);
        }
    }
    for (const Side side : {Side::kLeft, Side::kRight}) {
        if (std::count(sides.begin(), sides.end(), side) < std::int64_t{graph.size()} * kLeastPercent / 100)
            return false;
    }
    std::array<std::vector<Index>, 2> around;  // left and right of them
    std::vector<char> is_noted(graph.size(), 0);
    for (const Index v : near) {
        work.add(1 + graph.degree(v));
        for (const Index* u = graph.begin(v); u != graph.end(v); ++u) {
            if (sides[*u] == Side::kBetween || std::exchange(is_noted[*u], 1) != 0) continue;
            around[sides[*u] == Side::kLeft ? 0 : 1].push_back(*u);
        }
    }
    auto [vertices, right] = std::move(around);
    const auto left_end = static_cast<Index>(vertices.size());
    vertices.insert(vertices.end(), near.begin(), near.end());
    const auto right_begin = static_cast<Index>(vertices.size());
    vertices.insert(vertices.end(), right.begin(), right.end());
    take_sides(separate(graph, std::move(vertices), left_end, right_begin, work, execution), sides);
    return true;
}

}  // namespace

Cut balanced_separator(const Graph& graph, const Execution& execution) {
    WorkMeter work(execution);
    const Index size = graph.size();
    if (size > kSmallGraph) {
        const Clusters clusters = find_clusters(graph, work);
        if (clusters.graph.size() < size / 2) {
            Cut coarse = balanced_separator(clusters.graph, execution);
            std::vector<Side> cluster_sides = coarse.sides;
            take_sides(coarse, cluster_sides);
            Cut cut;
            cut.sides.resize(size);
            if (separate_near(clusters, cluster_sides, graph, cut.sides, work, execution)) return cut;
        }
    }
    const auto end_size = static_cast<Index>(std::int64_t{size} * kEndPercent / 100);
    return separate(graph, from_end_to_end(graph, work), end_size, size - end_size, work, execution);
}

}  // namespace meanvalue
