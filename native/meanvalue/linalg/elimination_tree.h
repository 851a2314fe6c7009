// Which column of a Cholesky factor depends on which, and how many entries each has; without finding the entries.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

/// A graph's vertices in the order of their elimination, with the elimination tree (J. W. H. Liu, The role of
/// elimination trees in sparse factorization, SIAM J. Matrix Anal. 11, 1990).
struct EliminationTree {
    std::vector<Index> vertex;   // that is k-th
    std::vector<Index> place;    // of each vertex: the inverse
    std::vector<Index> parents;  // of the k-th: the place of the first neighbor in the filled graph after it, or -1
    std::vector<Index> counts;   // of the k-th: entries of its column, the diagonal too
};

/// The tree for an order that fills as little as the one given: a postorder, in which each subtree is in one piece
/// that ends with its root.
/// @param order each vertex once. @throws Cancelled. Cost: about linear.
EliminationTree find_elimination_tree(const Graph& graph, std::vector<Index> order, const Execution& execution);

}  // namespace meanvalue
