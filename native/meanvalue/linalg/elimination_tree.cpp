#include <numeric>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/linalg/nested_dissection.h"

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
        for (const Index u : graph.of(vertex)) {
            Index column = tree.place[u];
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
        for (const Index u : graph.of(vertex)) {
            const Index row = tree.place[u];
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

/// The places of a forest's nodes in an order in which each subtree is in one piece that ends with its root.
/// @param parents each after its children, or -1.
std::vector<Index> postorder(const std::vector<Index>& parents, const Execution& execution) {
    const auto count = static_cast<Index>(parents.size());
    std::vector<Index> size(count, 1);  // of each subtree
    for (Index node = 0; node < count; ++node) {
        if (parents[node] >= 0) size[parents[node]] += size[node];
    }
    std::vector<Index> place(count);
    std::vector<Index> room(count);  // what is left for the children of each ends there
    Index room_of_roots = count;
    for (Index node = count; node-- > 0;) {
        execution.check_every(node);
        Index& end = parents[node] < 0 ? room_of_roots : room[parents[node]];
        place[node] = room[node] = end - 1;
        end -= size[node];
    }
    return place;
}

}  // namespace

EliminationTree find_elimination_tree(const Graph& graph, std::vector<Index> order, const Execution& execution) {
    EliminationTree tree;
    tree.vertex = std::move(order);
    tree.place = inverse(tree.vertex);
    WorkMeter work(execution);
    find_parents(graph, tree, work);
    const std::vector<Index> new_places = postorder(tree.parents, execution);
    const std::vector<Index> places = inverse(new_places);
    tree.vertex = picked(tree.vertex, places);
    tree.place = inverse(tree.vertex);
    tree.parents = picked(tree.parents, places);
    for (Index& parent : tree.parents)
        parent = parent < 0 ? -1 : new_places[parent];
    find_counts(graph, tree, work);
    return tree;
}

}  // namespace meanvalue
