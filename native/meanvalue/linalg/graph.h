// The graph of a symmetric sparse matrix, for which an order of elimination is found.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/sparse_matrix.h"

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

}  // namespace meanvalue
