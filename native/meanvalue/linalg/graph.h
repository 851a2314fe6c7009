// The graph of a symmetric sparse matrix, in which an order of elimination is looked for.
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
    std::vector<Index> weights;       // of each vertex: how many columns it stands for
    std::vector<Index> edge_weights;  // of each of the neighbours: how many edges it stands for; empty: one each

    Index size() const { return static_cast<Index>(weights.size()); }
    const Index* begin(Index vertex) const { return neighbours.data() + offsets[vertex]; }
    const Index* end(Index vertex) const { return neighbours.data() + offsets[vertex + 1]; }
    Index degree(Index vertex) const { return static_cast<Index>(offsets[vertex + 1] - offsets[vertex]); }
    std::int64_t total_weight() const;
};

/// Vertices of which each group is one vertex of a smaller graph.
struct VertexGroups {
    std::vector<Index> offsets = {0};  // groups + 1
    std::vector<Index> members;        // group after group
    std::vector<Index> group_of;       // each vertex

    Index count() const { return static_cast<Index>(offsets.size()) - 1; }
};

/// A vertex for each column, neighbours ascending. Only entries below the diagonal are looked at.
/// @throws Cancelled.
Graph graph_of(const SparseMatrix& lower, const Execution& execution);

/// Columns that have the same entries, as the three of a vertex of a mesh have: they can be eliminated one after
/// another at no more fill than one. @param graph of columns, neighbours ascending. @return members ascending.
/// @throws Cancelled.
VertexGroups group_same_columns(const Graph& graph, const Execution& execution);

/// A vertex for each group. @throws Cancelled.
Graph contracted(const Graph& graph, const VertexGroups& groups, const Execution& execution);

/// The same, of columns: the graph itself where each is a group of its own.
Graph contracted_columns(Graph columns, const VertexGroups& groups, const Execution& execution);

}  // namespace meanvalue
