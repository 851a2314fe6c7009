#include "meanvalue/linalg/nested_dissection.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/balanced_separator.h"

namespace meanvalue {
namespace {

// Vertices of a part that is ordered by minimum degree: more save time and cost fill.
constexpr Index kSmallPart = 600;

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
    std::vector<Part> parts;
    {
        Part whole{graph, std::vector<Index>(graph.size()), 0};
        std::iota(whole.vertices.begin(), whole.vertices.end(), 0);
        parts = split(whole, std::vector<Side>(graph.size(), Side::kLeft), order, work);
    }
    std::vector<std::vector<Index>> local(threads);  // one a worker
    while (!parts.empty()) {
        std::vector<std::vector<Part>> smaller(parts.size());
        parallel_items(parts.size(), threads, execution, [&](int worker, std::size_t k) {
            Part part = std::move(parts[k]);
            if (part.graph.size() <= kSmallPart) {
                local[worker].resize(graph.size(), -1);
                order_small_part(part, graph, local[worker], order);
                return;
            }
            WorkMeter own_work(execution);
            Cut cut = balanced_separator(part.graph, execution);
            if (!cut.vertices.empty()) {
                for (Index& v : cut.vertices)
                    v = part.vertices[v];
                part = {std::move(cut.graph), std::move(cut.vertices), part.place};
            }
            smaller[k] = split(part, cut.sides, order, own_work);
        });
        parts.clear();
        for (std::vector<Part>& of_one : smaller)
            std::move(of_one.begin(), of_one.end(), std::back_inserter(parts));
    }
    return order;
}

}  // namespace meanvalue
