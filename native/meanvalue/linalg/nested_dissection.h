// The order in which the columns of a sparse matrix are eliminated, so that the factor stays sparse.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

/// Nested dissection: a separator last, before it its two sides, each in the same way; small parts by minimum degree,
/// with what surrounds them (A. George, Nested dissection of a regular finite element mesh, SIAM J. Numer. Anal. 10,
/// 1973). The same order for any number of threads.
/// @param threads as given by thread_count(). @return the vertex that is k-th. @throws Cancelled.
std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution);

}  // namespace meanvalue
