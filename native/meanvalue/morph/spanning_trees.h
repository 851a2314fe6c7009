// Trees over the connected parts of a graph, along its cheapest edges.
#pragma once

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <tuple>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A node of a tree, with the one that it is reached from: itself, where a tree begins.
struct TreeStep {
    Index node;
    Index from;
    std::size_t edge;  ///< between both
};

/// Minimum spanning trees (Prim), each from the node with the least start cost.
/// @param edges called with a node and visit(neighbour, cost, number of the edge). @throws Cancelled.
/// @return all nodes, tree after tree, each after the one that it is reached from. Cost: e log e for e edges.
template <typename Edges>
std::vector<TreeStep> spanning_trees(const std::vector<double>& start_costs, const Edges& edges,
                                     const Execution& execution) {
    std::vector<Index> starts(start_costs.size());
    std::iota(starts.begin(), starts.end(), 0);
    std::stable_sort(starts.begin(), starts.end(), [&](Index a, Index b) { return start_costs[a] < start_costs[b]; });
    using Candidate = std::tuple<double, Index, Index, std::size_t>;  // cost, node, from, edge
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue;
    std::vector<char> is_known(start_costs.size(), 0);
    std::vector<TreeStep> steps;
    for (const Index start : starts) {
        if (!is_known[start]) queue.emplace(0.0, start, start, 0);
        while (!queue.empty()) {
            execution.check_every(steps.size());
            const Candidate next = queue.top();
            queue.pop();
            const Index node = std::get<1>(next);
            if (is_known[node]) continue;
            is_known[node] = 1;
            steps.push_back({node, std::get<2>(next), std::get<3>(next)});
            edges(node, [&](Index neighbour, double cost, std::size_t edge) {
                if (!is_known[neighbour]) queue.emplace(cost, neighbour, node, edge);
            });
        }
    }
    return steps;
}

}  // namespace meanvalue
