// The order in which the columns of a sparse matrix are eliminated, so that the factor stays sparse.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/dissection_tree.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

/// Nested dissection: a separator last, before it its two sides, each in the same way; small parts by minimum degree,
/// with what surrounds them (A. George, Nested dissection of a regular finite element mesh, SIAM J. Numer. Anal. 10,
/// 1973). The same order for any number of threads.
/// @param threads as given by thread_count(). @param tree receives the parts, or nullptr.
/// @return the vertex that is k-th. @throws Cancelled.
std::vector<Index> nested_dissection(const Graph& graph, int threads, const Execution& execution,
                                     DissectionTree* tree = nullptr);

/// The same, but that separators are sought near those of a graph like it, which takes a fraction of the time.
/// @param tree of the other graph. @param places of each vertex in the order of that.
std::vector<Index> nested_dissection_along(const DissectionTree& tree, const std::vector<Index>& places,
                                           const Graph& graph, int threads, const Execution& execution);

}  // namespace meanvalue
