#include "meanvalue/linalg/elimination_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace meanvalue {
namespace {

std::vector<Index> inverse(const std::vector<Index>& order) {
    std::vector<Index> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<Index>(k);
    return place;
}

/// Row after row: the columns in which a row of the factor has entries are those on the ways up the tree from the
/// entries of the matrix to the row itself.
void find_parents_and_counts(const Graph& graph, EliminationTree& tree, const Execution& execution) {
    const Index size = graph.size();
    tree.parents.assign(size, -1);
    tree.counts.assign(size, 1);
    std::vector<Index> seen_by(size, -1);
    WorkMeter work(execution);
    for (Index row = 0; row < size; ++row) {
        const Index vertex = tree.vertex[row];
        for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
            work.add(1);
            for (Index column = tree.place[*u]; column < row && seen_by[column] != row;
                 column = tree.parents[column]) {
                work.add(1);
                seen_by[column] = row;
                ++tree.counts[column];
                if (tree.parents[column] < 0) tree.parents[column] = row;
            }
        }
    }
}

/// The nodes of a forest so that each subtree is in one piece that ends with its root, and of several children those
/// with more weight come later. @param parents each after its children, or -1.
std::vector<Index> postorder(const std::vector<Index>& parents, const std::vector<Index>& weights,
                             const Execution& execution) {
    const auto count = static_cast<Index>(parents.size());
    std::vector<Index> by_weight(count);
    std::iota(by_weight.begin(), by_weight.end(), 0);
    std::stable_sort(by_weight.begin(), by_weight.end(), [&](Index a, Index b) { return weights[a] > weights[b]; });
    execution.check();
    // Linked lists, of which the last node that was put in is the first.
    std::vector<Index> first_child(count, -1);
    std::vector<Index> next_sibling(count, -1);
    std::vector<Index> stack;
    for (const Index node : by_weight) {
        if (parents[node] < 0) {
            stack.push_back(node);
        } else {
            next_sibling[node] = std::exchange(first_child[parents[node]], node);
        }
    }
    std::vector<Index> order;
    while (!stack.empty()) {
        const Index node = stack.back();
        const Index child = first_child[node];
        if (child >= 0) {
            first_child[node] = next_sibling[child];
            stack.push_back(child);
            continue;
        }
        execution.check_every(order.size());
        order.push_back(node);
        stack.pop_back();
    }
    return order;
}

template <typename Value>
std::vector<Value> picked(const std::vector<Value>& values, const std::vector<Index>& places) {
    std::vector<Value> result;
    result.reserve(places.size());
    for (const Index place : places)
        result.push_back(values[place]);
    return result;
}

}  // namespace

EliminationTree find_elimination_tree(const Graph& graph, std::vector<Index> order, const Execution& execution) {
    EliminationTree tree;
    tree.vertex = std::move(order);
    tree.place = inverse(tree.vertex);
    find_parents_and_counts(graph, tree, execution);
    const std::vector<Index> places = postorder(tree.parents, tree.counts, execution);
    const std::vector<Index> new_places = inverse(places);
    tree.vertex = picked(tree.vertex, places);
    tree.place = inverse(tree.vertex);
    tree.counts = picked(tree.counts, places);
    tree.parents = picked(tree.parents, places);
    for (Index& parent : tree.parents)
        parent = parent < 0 ? -1 : new_places[parent];
    return tree;
}

}  // namespace meanvalue
