// Which column of a Cholesky factor depends on which, and how many entries each has; without finding the entries.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

/// A graph whose vertices are eliminated in an order.
struct EliminationOrder {
    std::vector<Index> vertex;  // that is k-th
    std::vector<Index> place;   // of each vertex: the inverse

    /// @param vertices each once.
    explicit EliminationOrder(std::vector<Index> vertices);
    /// The k-th of the new order is what was at places[k].
    void rearrange(const std::vector<Index>& places);
};

/// For each place that of the first neighbour in the filled graph that comes after it, or -1: the elimination tree
/// (J. W. H. Liu, The role of elimination trees in sparse factorization, SIAM J. Matrix Anal. 11, 1990).
/// @throws Cancelled.
std::vector<Index> elimination_tree(const Graph& graph, const EliminationOrder& order, const Execution& execution);

/// The nodes of a forest so that each subtree is in one piece that ends with its root, and of several children those
/// with more weight come later. @param parents each after its children, or -1. @throws Cancelled.
std::vector<Index> postorder(const std::vector<Index>& parents, const std::vector<Index>& weights,
                             const Execution& execution);

/// A forest's nodes renamed: the k-th is what was order[k].
std::vector<Index> renamed_forest(const std::vector<Index>& parents, const std::vector<Index>& order);

/// The weight of all that is in the column of each place, the diagonal too (J. R. Gilbert, E. G. Ng, B. W. Peyton, An
/// efficient algorithm to compute row and column counts for sparse Cholesky factorization, SIAM J. Matrix Anal. 15,
/// 1994). @param parents the elimination tree, which is in postorder. @throws Cancelled.
std::vector<Index> column_counts(const Graph& graph, const EliminationOrder& order, const std::vector<Index>& parents,
                                 const Execution& execution);

}  // namespace meanvalue
