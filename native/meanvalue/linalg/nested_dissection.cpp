#include "meanvalue/linalg/nested_dissection.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/vertex_separator.h"

namespace meanvalue {
namespace {

// Vertices of a part that is ordered by minimum degree: more save time and cost fill.
constexpr Index kSmallPart = 300;
// Share of a part that each of its ends takes, in percent: less lets separators be smaller, and takes longer.
constexpr std::int64_t kEndPercent = 40;

/// A connected part of the graph, and the places in the order that it is to fill.
struct Part {
    Graph graph;
    std::vector<Index> vertices;  // in the whole graph
    Index place = 0;              // the first
};

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

/// The same part with its vertices numbered as they are in `vertices`; neighbours descending, so that the search for
/// paths goes to the other end first.
Part renumbered(const Part& part, const std::vector<Index>& vertices, WorkMeter& work) {
    const Graph& graph = part.graph;
    std::vector<Index> number(vertices.size());
    Part result;
    result.place = part.place;
    for (const Index v : vertices) {
        number[v] = static_cast<Index>(result.vertices.size());
        result.vertices.push_back(part.vertices[v]);
        result.graph.offsets.push_back(result.graph.offsets.back() + graph.degree(v));
    }
    result.graph.neighbours.resize(graph.neighbours.size());
    std::vector<std::int64_t> next(result.graph.offsets.begin(), result.graph.offsets.end() - 1);
    for (Index k = graph.size(); k-- > 0;) {
        work.add(1 + graph.degree(vertices[k]));
        for (const Index* u = graph.begin(vertices[k]); u != graph.end(vertices[k]); ++u)
            result.graph.neighbours[next[number[*u]]++] = k;
    }
    return result;
}

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
            work.add(4 + graph.degree(v));
            for (const Index* u = graph.begin(v); u != graph.end(v); ++u) {
                if (sides[*u] == Side::kBetween) continue;
                if (number[*u] < 0) {
                    number[*u] = static_cast<Index>(queue.size());
                    queue.push_back(*u);
                }
                part.graph.neighbours.push_back(number[*u]);
            }
            part.graph.offsets.push_back(static_cast<std::int64_t>(part.graph.neighbours.size()));
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

/// By minimum degree. The separators around the part count as neighbours of each other, which come later.
/// @param local n numbers, -1; as they were at the end.
void order_small_part(const Part& part, const Graph& whole, std::vector<Index>& local, std::vector<Index>& order) {
    const Index inner = part.graph.size();
    std::vector<Index> vertices = part.vertices;  // then those around it
    for (Index k = 0; k < inner; ++k)
        local[vertices[k]] = k;
    std::vector<Index> rows;  // of the lower triangle, column after column
    std::vector<Index> begins = {0};
    for (Index k = 0; k < inner; ++k) {
        rows.push_back(k);
        for (const Index* u = whole.begin(part.vertices[k]); u != whole.end(part.vertices[k]); ++u) {
            if (local[*u] < 0) {
                local[*u] = static_cast<Index>(vertices.size());
                vertices.push_back(*u);
            }
            if (local[*u] > k) rows.push_back(local[*u]);
        }
        begins.push_back(static_cast<Index>(rows.size()));
    }
    const auto size = static_cast<Index>(vertices.size());
    for (Index k = inner; k < size; ++k) {
        for (Index row = k; row < size; ++row)
            rows.push_back(row);
        begins.push_back(static_cast<Index>(rows.size()));
    }
    Eigen::SparseMatrix<char, Eigen::ColMajor, Index> lower(size, size);
    lower.resizeNonZeros(begins.back());
    std::copy(begins.begin(), begins.end(), lower.outerIndexPtr());
    std::copy(rows.begin(), rows.end(), lower.innerIndexPtr());
    std::fill_n(lower.valuePtr(), begins.back(), 1);
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> found;
    Eigen::AMDOrdering<Index>()(lower.selfadjointView<Eigen::Lower>(), found);
    Index place = part.place;
    for (const Index k : found.indices()) {
        if (k < inner) order[place++] = vertices[k];
    }
    for (const Index v : vertices)
        local[v] = -1;
}

}  // namespace

std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution) {
    std::vector<Index> order(graph.size());
    WorkMeter work(execution);
    Part whole{graph, std::vector<Index>(graph.size()), 0};
    std::iota(whole.vertices.begin(), whole.vertices.end(), 0);
    std::vector<Part> parts = split(whole, std::vector<Side>(graph.size(), Side::kLeft), order, work);
    std::vector<std::vector<Index>> local(threads);  // one a worker
    while (!parts.empty()) {
        std::vector<std::vector<Part>> smaller(parts.size());
        parallel_items(parts.size(), threads, execution, [&](int worker, std::size_t k) {
            const Part part = std::move(parts[k]);
            if (part.graph.size() <= kSmallPart) {
                local[worker].resize(graph.size(), -1);
                order_small_part(part, graph, local[worker], order);
                return;
            }
            WorkMeter own_work(execution);
            const Part sorted = renumbered(part, from_end_to_end(part.graph, own_work), own_work);
            const Index size = part.graph.size();
            const auto end_size = static_cast<Index>(size * kEndPercent / 100);
            smaller[k] =
                split(sorted, minimum_separator(sorted.graph, end_size, size - end_size, execution), order, own_work);
        });
        parts.clear();
        for (std::vector<Part>& of_one : smaller)
            std::move(of_one.begin(), of_one.end(), std::back_inserter(parts));
    }
    return order;
}

}  // namespace meanvalue
