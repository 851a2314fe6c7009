// The order in which the columns of a sparse matrix are eliminated, so that the factor stays sparse.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

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
