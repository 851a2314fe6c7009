// The graph of a symmetric sparse matrix, for which an order of elimination is found.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/block_matrix.h"

namespace meanvalue {

/// Undirected, without loops: each edge is in the list of both its ends.
struct Graph {
    std::vector<std::int64_t> offsets = {0};  // size() + 1
    std::vector<Index> neighbours;

    Index size() const { return static_cast<Index>(offsets.size()) - 1; }
    const Index* begin(Index vertex) const { return neighbours.data() + offsets[vertex]; }
    const Index* end(Index vertex) const { return neighbours.data() + offsets[vertex + 1]; }
    Index degree(Index vertex) const { return static_cast<Index>(offsets[vertex + 1] - offsets[vertex]); }
};

/// A vertex for each column, neighbours ascending. Only entries below the diagonal are looked at.
/// @throws Cancelled.
Graph graph_of(const SparseMatrix& lower, const Execution& execution);

/// Groups of consecutive columns that have the same entries, as the three of a vertex of a mesh have: they can be
/// eliminated one after another at no more fill than one. @param graph of columns, neighbours ascending.
/// @return the first column of each group, then the number of columns. @throws Cancelled.
std::vector<Index> group_same_columns(const Graph& graph, const Execution& execution);

/// A vertex for each group, neighbours ascending. @param first as group_same_columns() returns it.
/// @throws Cancelled.
Graph contracted(const Graph& columns, const std::vector<Index>& first, const Execution& execution);

}  // namespace meanvalue
