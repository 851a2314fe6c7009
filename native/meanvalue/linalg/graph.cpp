#include "meanvalue/linalg/graph.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace meanvalue {
namespace {

/// Scrambles a number, so that sums of them tell sets of vertices apart (the last step of SplitMix64).
std::uint64_t scrambled(std::uint64_t number) {
    number += 0x9e3779b97f4a7c15U;
    number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9U;
    number = (number ^ (number >> 27)) * 0x94d049bb133111ebU;
    return number ^ (number >> 31);
}

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

std::int64_t Graph::total_weight() const {
    return std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
}

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
    graph.weights.assign(size, 1);
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

VertexGroups group_same_columns(const Graph& graph, const Execution& execution) {
    const Index size = graph.size();
    std::vector<std::uint64_t> number(size);
    for (Index v = 0; v < size; ++v)
        number[v] = scrambled(v);
    std::vector<std::uint64_t> key = number;
    for (Index v = 0; v < size; ++v) {
        execution.check_every(v);
        for (const Index* u = graph.begin(v); u != graph.end(v); ++u)
            key[v] += number[*u];
    }
    VertexGroups groups;
    groups.group_of.assign(size, -1);
    groups.members.reserve(size);
    for (Index v = 0; v < size; ++v) {
        execution.check_every(v);
        if (groups.group_of[v] >= 0) continue;
        const auto group = static_cast<Index>(groups.offsets.size()) - 1;
        groups.group_of[v] = group;
        groups.members.push_back(v);
        for (const Index* u = graph.begin(v); u != graph.end(v); ++u) {
            if (key[*u] != key[v] || *u < v || groups.group_of[*u] >= 0) continue;
            if (!same_closed_neighbours(graph, v, *u)) continue;
            groups.group_of[*u] = group;
            groups.members.push_back(*u);
        }
        groups.offsets.push_back(static_cast<Index>(groups.members.size()));
    }
    return groups;
}

Graph contracted(const Graph& graph, const VertexGroups& groups, const Execution& execution) {
    const Index count = groups.count();
    Graph result;
    result.weights.assign(count, 0);
    result.offsets.reserve(count + 1);
    std::vector<Index> seen_by(count, -1);
    std::vector<std::size_t> place(count);  // of what was seen, among the neighbours
    WorkMeter work(execution);
    for (Index group = 0; group < count; ++group) {
        for (Index k = groups.offsets[group]; k < groups.offsets[group + 1]; ++k) {
            const Index member = groups.members[k];
            work.add(1 + graph.degree(member));
            result.weights[group] += graph.weights[member];
            for (const Index* u = graph.begin(member); u != graph.end(member); ++u) {
                const Index other = groups.group_of[*u];
                if (other == group) continue;
                const Index edges = graph.edge_weights.empty() ? 1 : graph.edge_weights[u - graph.neighbours.data()];
                if (seen_by[other] == group) {
                    result.edge_weights[place[other]] += edges;
                    continue;
                }
                seen_by[other] = group;
                place[other] = result.neighbours.size();
                result.neighbours.push_back(other);
                result.edge_weights.push_back(edges);
            }
        }
        result.offsets.push_back(static_cast<std::int64_t>(result.neighbours.size()));
    }
    return result;
}

Graph contracted_columns(Graph columns, const VertexGroups& groups, const Execution& execution) {
    return groups.count() == columns.size() ? std::move(columns) : contracted(columns, groups, execution);
}

}  // namespace meanvalue
