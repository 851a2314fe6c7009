#include "meanvalue/linalg/nested_dissection.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// Vertices of a part that is ordered by minimum degree: more save time and cost fill.
constexpr Index kSmallPart = 150;
// A connected graph of at most so many is ordered by minimum degree first, which takes a fifth of the time and cannot
// be canceled.
constexpr Index kMostAtOnce = 100000;
// It stays so where a column of the factor has no more entries than this: of long and thin shapes. On compact ones
// dissection leaves a quarter less, and frames take less time (docs/decisions/0032-cuts-of-large-meshes.md).
constexpr std::int64_t kThinFactor = 100;

/// A connected part of the graph, and the places in the order that it is to fill.
struct Part {
    Graph graph;
    std::vector<Index> vertices;  // in the whole graph
    Index place = 0;              // the first
};

/// What is connected of a part without its separator, which comes last.
std::vector<Part> split(const Part& whole, const std::vector<Side>& sides, std::vector<Index>& order,
                        WorkMeter& work) {
    const Graph& graph = whole.graph;
    std::vector<Part> parts;
    Index place = whole.place;
    std::vector<Index> number(graph.size(), -1);  // in its part
    std::vector<Index> queue;
    for (Index seed = 0; seed < graph.size(); ++seed) {
        if (sides[seed] == Side::kBetween || number[seed] >= 0) continue;
        Part part;
        part.place = place;
        queue.assign(1, seed);
        number[seed] = 0;
        for (std::size_t k = 0; k < queue.size(); ++k) {
            const Index v = queue[k];
            work.add(4 + graph.of(v).size());
            for (const Index u : graph.of(v)) {
                if (sides[u] == Side::kBetween) continue;
                if (number[u] < 0) {
                    number[u] = static_cast<Index>(queue.size());
                    queue.push_back(u);
                }
                part.graph.items.push_back(number[u]);
            }
            part.graph.offsets.push_back(static_cast<std::int64_t>(part.graph.items.size()));
            part.vertices.push_back(whole.vertices[v]);
        }
        place += part.graph.size();
        parts.push_back(std::move(part));
    }
    for (Index v = 0; v < graph.size(); ++v) {
        if (sides[v] == Side::kBetween) order[place++] = whole.vertices[v];
    }
    return parts;
}

std::vector<Index> by_minimum_degree(const Graph& graph) {
    Eigen::SparseMatrix<char, Eigen::ColMajor, Index> matrix(graph.size(), graph.size());
    matrix.resizeNonZeros(static_cast<Eigen::Index>(graph.items.size()) + graph.size());
    Index* row = matrix.innerIndexPtr();
    for (Index v = 0; v < graph.size(); ++v) {
        *row++ = v;
        row = std::copy(graph.of(v).begin(), graph.of(v).end(), row);
        matrix.outerIndexPtr()[v + 1] = static_cast<Index>(row - matrix.innerIndexPtr());
    }
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> found;
    Eigen::internal::minimum_degree_ordering(matrix, found);
    return {found.indices().begin(), found.indices().end()};
}

/// Whether a part is to be ordered so; writes its order then.
bool order_at_once(const Part& part, bool is_whole, std::vector<Index>& order, const Execution& execution) {
    const Index size = part.graph.size();
    if (size > (is_whole ? kMostAtOnce : kSmallPart)) return false;
    const std::vector<Index> found = by_minimum_degree(part.graph);
    if (size > kSmallPart) {
        const std::vector<Index> counts = find_elimination_tree(part.graph, found, execution).counts;
        if (std::accumulate(counts.begin(), counts.end(), std::int64_t{0}) > kThinFactor * size) return false;
    }
    std::transform(found.begin(), found.end(), order.begin() + part.place, [&](Index k) { return part.vertices[k]; });
    return true;
}

// A cut leaves this share of a graph on each side, in percent: less finds thinner places, and makes the larger side
// larger.
constexpr std::int64_t kLeastCut = 27;

/// In edges, from one vertex.
std::vector<Index> distances(const Graph& graph, Index from, WorkMeter& work) {
    std::vector<Index> distance(graph.size(), -1);
    std::vector<Index> queue = {from};
    queue.reserve(graph.size());
    distance[from] = 0;
    for (std::size_t k = 0; k < queue.size(); ++k) {
        work.add(1 + graph.of(queue[k]).size());
        for (const Index u : graph.of(queue[k])) {
            if (distance[u] >= 0) continue;
            distance[u] = distance[queue[k]] + 1;
            queue.push_back(u);
        }
    }
    return distance;
}

/// From each of four vertices that are far from each other.
std::array<std::vector<Index>, 4> distances_from_extremes(const Graph& graph, WorkMeter& work) {
    std::array<std::vector<Index>, 4> result;
    std::vector<Index> nearest(graph.size(), graph.size());
    Index from = graph.size() - 1;
    for (std::vector<Index>& distance : result) {
        distance = distances(graph, from, work);
        for (Index v = 0; v < graph.size(); ++v)
            nearest[v] = std::min(nearest[v], distance[v]);
        from = static_cast<Index>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    }
    return result;
}

/// Vertices from one end of a graph to the other, cut in two.
struct Line {
    std::vector<Index> vertices;
    Index left_end = 0;
    std::int64_t cost = std::numeric_limits<std::int64_t>::max();
};

/// Cut where the fewest vertices before have neighbours behind, and both sides have about the same size.
/// @param heights n: at one end the lowest, at the other the highest.
Line cut_line(const Graph& graph, const std::vector<Index>& heights, WorkMeter& work) {
    const Index size = graph.size();
    const auto [lowest, highest] = std::minmax_element(heights.begin(), heights.end());
    Line line;
    line.vertices = grouped<Index>(*highest - *lowest + 1, [&, low = *lowest](const auto& visit) {
                        for (Index v = 0; v < size; ++v)
                            visit(heights[v] - low, v);
                    }).items;
    std::vector<Index> place(size);
    for (Index k = 0; k < size; ++k)
        place[line.vertices[k]] = k;
    const Index first = std::max(static_cast<Index>(size * kLeastCut / 100), 1);
    std::vector<Index> change(size + 1, 0);  // of the border, from one cut to the next
    for (Index k = 0; k < size - first; ++k) {
        const Index v = line.vertices[k];
        work.add(1 + graph.of(v).size());
        Index farthest = k;
        for (const Index u : graph.of(v))
            farthest = std::max(farthest, place[u]);
        ++change[k + 1];
        --change[farthest + 1];
    }
    std::int64_t border = 0;
    for (Index end = 0; end <= size - first; ++end) {
        border += change[end];
        const std::int64_t cost = border * (2 * size + std::abs(size - 2 * end + border));
        if (end < first || cost >= line.cost) continue;
        line.left_end = end;
        line.cost = cost;
    }
    return line;
}

/// The four extremes a, b, c, d are at the ends in one of the ways a | b, ac | bd, ad | bc, or one of them alone.
Line best_line(const Graph& graph, WorkMeter& work) {
    constexpr Index kWays[][4] = {{1, -1, 0, 0}, {1, -1, 1, -1}, {1, -1, -1, 1}, {1, 0, 0, 0},
                                  {0, 1, 0, 0},  {0, 0, 1, 0},   {0, 0, 0, 1}};
    const std::array<std::vector<Index>, 4> distance = distances_from_extremes(graph, work);
    Line best;
    for (const auto& way : kWays) {
        std::vector<Index> heights(graph.size(), 0);
        for (std::size_t k = 0; k < distance.size(); ++k) {
            for (Index v = 0; v < graph.size(); ++v)
                heights[v] += way[k] * distance[k][v];
        }
        Line line = cut_line(graph, heights, work);
        if (line.cost < best.cost) best = std::move(line);
    }
    return best;
}

}  // namespace

std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution) {
    std::vector<Index> order(graph.size());
    WorkMeter work(execution);
    std::vector<Part> parts;
    {
        Part whole{graph, std::vector<Index>(graph.size()), 0};
        std::iota(whole.vertices.begin(), whole.vertices.end(), 0);
        parts = split(whole, std::vector<Side>(graph.size(), Side::kLeft), order, work);
    }
    for (bool is_whole = true; !parts.empty(); is_whole = false) {
        std::vector<std::vector<Part>> smaller(parts.size());
        parallel_items(parts.size(), threads, execution, [&](int, std::size_t k) {
            const Part part = std::move(parts[k]);
            if (order_at_once(part, is_whole, order, execution)) return;
            WorkMeter own_work(execution);
            smaller[k] = split(part, balanced_separator(part.graph, execution), order, own_work);
        });
        parts.clear();
        for (std::vector<Part>& of_one : smaller)
            std::move(of_one.begin(), of_one.end(), std::back_inserter(parts));
    }
    return order;
}

std::vector<Side> balanced_separator(const Graph& graph, const Execution& execution) {
    WorkMeter work(execution);
    const Line line = best_line(graph, work);
    const auto end = line.vertices.begin() + line.left_end;
    std::vector<Side> sides(graph.size(), Side::kLeft);
    for (auto v = end; v != line.vertices.end(); ++v)
        sides[*v] = Side::kRight;
    const auto touches = [&](Index vertex, Side side) {
        const auto around = graph.of(vertex);
        return std::any_of(around.begin(), around.end(), [&](Index u) { return sides[u] == side; });
    };
    for (auto v = line.vertices.begin(); v != end; ++v)
        if (touches(*v, Side::kRight)) sides[*v] = Side::kBetween;
    // Where all of the left is between, as in a clique, none of it may go: the part would be as large as before.
    if (std::find(sides.begin(), sides.end(), Side::kLeft) == sides.end()) return sides;
    for (auto v = std::make_reverse_iterator(end); v != line.vertices.rend(); ++v)
        if (sides[*v] == Side::kBetween && !touches(*v, Side::kLeft)) sides[*v] = Side::kRight;
    return sides;
}

}  // namespace meanvalue
