#include "meanvalue/linalg/elimination_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/grouped.h"

namespace meanvalue {
namespace {

std::vector<Index> inverse(const std::vector<Index>& order) {
    std::vector<Index> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<Index>(k);
    return place;
}

/// Row after row: the next parent is found at the top of what is known of the tree above each entry of the matrix.
void find_parents(const Graph& graph, EliminationTree& tree, WorkMeter& work) {
    const Index size = graph.size();
    tree.parents.assign(size, -1);
    std::vector<Index> above(size, -1);  // shortcuts up the tree
    for (Index row = 0; row < size; ++row) {
        const Index vertex = tree.vertex[row];
        for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
            Index column = tree.place[*u];
            while (column >= 0 && column < row) {
                work.add(1);
                const Index next = std::exchange(above[column], row);
                if (next < 0) tree.parents[column] = row;
                column = next;
            }
        }
    }
}

/// A row has entries in the columns on the ways from its leaves up to itself: one more column for each leaf, one less
/// where two of the ways meet (J. R. Gilbert, E. G. Ng, B. W. Peyton, An efficient algorithm to compute row and
/// column counts for sparse Cholesky factorization, SIAM J. Matrix Anal. 15, 1994). @pre in postorder.
void find_counts(const Graph& graph, EliminationTree& tree, WorkMeter& work) {
    const Index size = graph.size();
    tree.counts.assign(size, 0);
    std::vector<Index> first(size, -1);      // descendant
    std::vector<Index> last_leaf(size, -1);  // of each row
    std::vector<Index> above(size);          // shortcuts to the top of what was visited
    std::iota(above.begin(), above.end(), 0);
    for (Index column = 0; column < size; ++column) {
        const Index parent = tree.parents[column];
        if (first[column] < 0) {
            first[column] = column;
            ++tree.counts[column];
        }
        if (parent >= 0) {
            if (first[parent] < 0) first[parent] = first[column];
            --tree.counts[parent];
        }
        const Index vertex = tree.vertex[column];
        for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
            const Index row = tree.place[*u];
            work.add(1);
            if (row < column || first[column] <= last_leaf[row]) continue;
            ++tree.counts[column];
            Index meeting = std::exchange(last_leaf[row], column);
            if (meeting < 0) continue;
            while (above[meeting] != meeting) {
                work.add(1);
                meeting = std::exchange(above[meeting], above[above[meeting]]);
            }
            --tree.counts[meeting];
        }
        if (parent >= 0) above[column] = parent;
    }
    for (Index column = 0; column < size; ++column) {
        if (tree.parents[column] >= 0) tree.counts[tree.parents[column]] += tree.counts[column];
    }
}

/// The nodes of a forest so that each subtree is in one piece that ends with its root.
/// @param parents each after its children, or -1.
std::vector<Index> postorder(const std::vector<Index>& parents, const Execution& execution) {
    const auto count = static_cast<Index>(parents.size());
    // Linked lists, of which the last node that was put in is the first.
    std::vector<Index> first_child(count, -1);
    std::vector<Index> next_sibling(count, -1);
    std::vector<Index> stack;
    for (Index node = count; node-- > 0;) {
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

}  // namespace

EliminationTree find_elimination_tree(const Graph& graph, std::vector<Index> order, const Execution& execution) {
    EliminationTree tree;
    tree.vertex = std::move(order);
    tree.place = inverse(tree.vertex);
    WorkMeter work(execution);
    find_parents(graph, tree, work);
    const std::vector<Index> places = postorder(tree.parents, execution);
    const std::vector<Index> new_places = inverse(places);
    tree.vertex = picked(tree.vertex, places);
    tree.place = inverse(tree.vertex);
    tree.parents = picked(tree.parents, places);
    for (Index& parent : tree.parents)
        parent = parent < 0 ? -1 : new_places[parent];
    find_counts(graph, tree, work);
    return tree;
}

}  // namespace meanvalue
