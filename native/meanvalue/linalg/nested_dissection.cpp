#include "meanvalue/linalg/nested_dissection.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/balanced_separator.h"
#include "meanvalue/linalg/elimination_tree.h"

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

}  // namespace meanvalue
