// The order in which the columns of a sparse matrix are eliminated, so that the factor stays sparse.
#pragma once

#include <cstdint>
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

enum class Side : std::uint8_t { kLeft, kRight, kBetween };

/// Cuts the graph where it is thin between two of its ends.
/// @param graph connected, of two vertices or more. Best where the last vertex is far from the first, as in
/// breadth-first order.
/// @return the side of each vertex, kBetween for those of the separator; no edge joins left and right.
/// @throws Cancelled. Cost: about linear.
std::vector<Side> balanced_separator(const Graph& graph, const Execution& execution);

/// Each connected part by minimum degree (P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree
/// ordering algorithm, SIAM J. Matrix Anal. 17, 1996) where little is filled so; else by nested dissection: a
/// separator last, before it what it separates, each in the same way (A. George, Nested dissection of a regular
/// finite element mesh, SIAM J. Numer. Anal. 10, 1973), small parts by minimum degree.
/// @param threads as given by thread_count(); the order is the same for any.
/// @return the vertex that is k-th. @throws Cancelled.
std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution);

}  // namespace meanvalue
