#include "meanvalue/linalg/elimination_tree.h"

#include <algorithm>
#include <utility>

namespace meanvalue {
namespace {

std::vector<Index> inverse(const std::vector<Index>& order) {
    std::vector<Index> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<Index>(k);
    return place;
}

/// The rows of A by the trees of columns that they have entries in: finds the leaves of each, in postorder.
class RowSubtrees {
  public:
    explicit RowSubtrees(const std::vector<Index>& parents)
        : parents_(parents),
          first_(parents.size()),
          last_first_(parents.size(), -1),
          last_leaf_(parents.size(), -1),
          ancestor_(parents.size()) {
        const auto count = static_cast<Index>(parents.size());
        for (Index node = 0; node < count; ++node)
            first_[node] = ancestor_[node] = node;
        for (Index node = 0; node < count; ++node) {
            if (parents[node] >= 0) first_[parents[node]] = std::min(first_[parents[node]], first_[node]);
        }
    }

    bool is_leaf_of_forest(Index node) const { return first_[node] == node; }

    /// Whether `column`, an entry in `row` not before the ones asked for, is a leaf of the row's tree.
    /// @param fork then the node where its way to the root meets the way of the leaf before it, or -1.
    bool is_leaf(Index row, Index column, Index& fork) {
        if (first_[column] <= last_first_[row]) return false;
        last_first_[row] = first_[column];
        fork = last_leaf_[row] < 0 ? -1 : root_of(last_leaf_[row]);
        last_leaf_[row] = column;
        return true;
    }

    /// All entries of the column have been asked for.
    void finish(Index column) {
        if (parents_[column] >= 0) ancestor_[column] = parents_[column];
    }

  private:
    Index root_of(Index node) {
        Index root = node;
        while (ancestor_[root] != root)
            root = ancestor_[root];
        while (ancestor_[node] != root)
            node = std::exchange(ancestor_[node], root);
        return root;
    }

    const std::vector<Index>& parents_;
    std::vector<Index> first_;       // of the subtree
    std::vector<Index> last_first_;  // of each row's last leaf
    std::vector<Index> last_leaf_;
    std::vector<Index> ancestor_;  // in the forest of what is finished; ways are shortened
};

}  // namespace

EliminationOrder::EliminationOrder(std::vector<Index> vertices)
    : vertex(std::move(vertices)), place(inverse(vertex)) {}

void EliminationOrder::rearrange(const std::vector<Index>& places) {
    std::vector<Index> rearranged(vertex.size());
    for (std::size_t k = 0; k < vertex.size(); ++k)
        rearranged[k] = vertex[places[k]];
    vertex = std::move(rearranged);
    place = inverse(vertex);
}

std::vector<Index> elimination_tree(const Graph& graph, const EliminationOrder& order, const Execution& execution) {
    const Index size = graph.size();
    std::vector<Index> parents(size, -1);
    std::vector<Index> ancestor(size, -1);  // a way up that is shortened
    WorkMeter work(execution);
    for (Index k = 0; k < size; ++k) {
        const Index vertex = order.vertex[k];
        work.add(4 + graph.degree(vertex));
        for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
            Index node = order.place[*u];
            if (node > k) continue;
            while (node >= 0 && node != k) {
                const Index next = std::exchange(ancestor[node], k);
                if (next < 0) parents[node] = k;
                node = next;
            }
        }
    }
    return parents;
}

std::vector<Index> postorder(const std::vector<Index>& parents, const std::vector<Index>& weights,
                             const Execution& execution) {
    const auto count = static_cast<Index>(parents.size());
    std::vector<Index> by_weight(count);
    for (Index node = 0; node < count; ++node)
        by_weight[node] = node;
    std::stable_sort(by_weight.begin(), by_weight.end(), [&](Index a, Index b) { return weights[a] < weights[b]; });
    execution.check();
    // Linked lists, with what comes later in the order in front: a stack turns them round.
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
    // From the last to the first: a root, then its children, the last of them first.
    std::vector<Index> order(count);
    for (Index place = count; !stack.empty();) {
        const Index node = stack.back();
        stack.pop_back();
        order[--place] = node;
        execution.check_every(place);
        const std::size_t begin = stack.size();
        for (Index child = first_child[node]; child >= 0; child = next_sibling[child])
            stack.push_back(child);
        std::reverse(stack.begin() + static_cast<std::ptrdiff_t>(begin), stack.end());
    }
    return order;
}

std::vector<Index> renamed_forest(const std::vector<Index>& parents, const std::vector<Index>& order) {
    const std::vector<Index> place = inverse(order);
    std::vector<Index> renamed(parents.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        renamed[k] = parents[order[k]] < 0 ? -1 : place[parents[order[k]]];
    return renamed;
}

std::vector<Index> column_counts(const Graph& graph, const EliminationOrder& order, const std::vector<Index>& parents,
                                 const Execution& execution) {
    const Index size = graph.size();
    std::vector<Index> counts(size, 0);  // first the difference to the sum over the children
    RowSubtrees subtrees(parents);
    WorkMeter work(execution);
    for (Index column = 0; column < size; ++column) {
        const Index vertex = order.vertex[column];
        work.add(4 + graph.degree(vertex));
        if (subtrees.is_leaf_of_forest(column)) counts[column] += graph.weights[vertex];
        if (parents[column] >= 0) counts[parents[column]] -= graph.weights[vertex];
        for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
            const Index row = order.place[*u];
            Index fork = -1;
            if (row < column || !subtrees.is_leaf(row, column, fork)) continue;
            counts[column] += graph.weights[*u];
            if (fork >= 0) counts[fork] -= graph.weights[*u];
        }
        subtrees.finish(column);
    }
    for (Index column = 0; column < size; ++column) {
        if (parents[column] >= 0) counts[parents[column]] += counts[column];
    }
    return counts;
}

}  // namespace meanvalue
