#include "meanvalue/linalg/graph.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace meanvalue {
namespace {

/// Whether a and b, which are neighbours, have the same neighbours otherwise.
bool same_closed_neighbours(const Graph& graph, Index a, Index b) {
    if (graph.degree(a) != graph.degree(b)) return false;
    const Index* in_a = graph.begin(a);
    const Index* in_b = graph.begin(b);
    const Index* const end_a = graph.end(a);
    const Index* const end_b = graph.end(b);
    while (true) {
        if (in_a != end_a && *in_a == b) ++in_a;
        if (in_b != end_b && *in_b == a) ++in_b;
        if (in_a == end_a || in_b == end_b) return in_a == end_a && in_b == end_b;
        if (*in_a++ != *in_b++) return false;
    }
}

}  // namespace

Graph graph_of(const SparseMatrix& lower, const Execution& execution) {
    const auto size = static_cast<Index>(lower.cols());
    const auto each_edge = [&](const auto& action) {
        for (Index column = 0; column < size; ++column) {
            execution.check_every(column);
            for (std::int64_t k = lower.outerIndexPtr()[column]; k < lower.outerIndexPtr()[column + 1]; ++k) {
                const auto row = static_cast<Index>(lower.innerIndexPtr()[k]);
                if (row > column) action(row, column);
            }
        }
    };
    Graph graph;
    graph.offsets.assign(size + 1, 0);
    each_edge([&](Index row, Index column) {
        ++graph.offsets[row + 1];
        ++graph.offsets[column + 1];
    });
    std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
    graph.neighbours.resize(graph.offsets.back());
    std::vector<std::int64_t> next(graph.offsets.begin(), graph.offsets.end() - 1);
    // Column after column: what comes before a vertex is in its list before what comes after it, ascending.
    each_edge([&](Index row, Index column) {
        graph.neighbours[next[row]++] = column;
        graph.neighbours[next[column]++] = row;
    });
    return graph;
}

std::vector<Index> group_same_columns(const Graph& graph, const Execution& execution) {
    std::vector<Index> first;
    for (Index v = 0; v < graph.size(); ++v) {
        execution.check_every(v);
        const bool goes_on = v > 0 && std::binary_search(graph.begin(v), graph.end(v), v - 1) &&
                             same_closed_neighbours(graph, v - 1, v);
        if (!goes_on) first.push_back(v);
    }
    first.push_back(graph.size());
    return first;
}

Graph contracted(const Graph& columns, const std::vector<Index>& first, const Execution& execution) {
    const auto count = static_cast<Index>(first.size()) - 1;
    std::vector<Index> group_of(columns.size());
    for (Index group = 0; group < count; ++group)
        std::fill(group_of.begin() + first[group], group_of.begin() + first[group + 1], group);
    Graph result;
    result.offsets.reserve(count + 1);
    for (Index group = 0; group < count; ++group) {
        execution.check_every(group);
        Index last = -1;
        for (const Index* u = columns.begin(first[group]); u != columns.end(first[group]); ++u) {
            const Index other = group_of[*u];
            if (other != group && other != last) result.neighbours.push_back(other);
            last = other;
        }
        result.offsets.push_back(static_cast<std::int64_t>(result.neighbours.size()));
    }
    return result;
}

}  // namespace meanvalue
