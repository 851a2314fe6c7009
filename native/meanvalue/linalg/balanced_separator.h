// A small set of vertices that cuts a graph into two parts of about the same size.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/vertex_separator.h"

namespace meanvalue {

/// A graph with the side of each vertex; no edge joins left and right.
struct Cut {
    std::vector<Index> vertices;  ///< what is k-th here, in the graph that was given; empty: all, as they are there
    Graph graph;                  ///< numbered so, or empty with them
    std::vector<Side> sides;
};

/// Of small graphs the minimum_separator() of both ends. Large ones are cut where neighbours taken as one are, and
/// the separator is the smallest near that cut (G. Karypis, V. Kumar, A fast and high quality multilevel scheme for
/// partitioning irregular graphs, SIAM J. Sci. Comput. 20, 1998).
/// @param graph connected. @throws Cancelled.
/// Cost: about linear.
Cut balanced_separator(const Graph& graph, const Execution& execution);

}  // namespace meanvalue
