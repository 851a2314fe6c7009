// An order of elimination for the unknowns of a mesh, whichever of its vertices are fixed.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/block_matrix.h"
#include "meanvalue/linalg/dissection_tree.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// All vertices of a mesh in an order of elimination, with the parts of the dissection that it came from.
struct RegionOrder {
    std::vector<Index> vertices;
    DissectionTree tree;

    bool empty() const { return vertices.empty(); }
    std::size_t bytes() const { return vertices.size() * sizeof(Index) + tree.bytes(); }
};

/// All vertices, in an order that leaves little fill in matrices that couple each two vertices of a row, a vertex and
/// its ring. Without those that are fixed it is an order of the same quality for the others: what separates two parts
/// of a mesh separates what is left of them. So it is found once, for all anchors.
/// @param threads as given by thread_count(); the result is the same for any. @throws Cancelled.
RegionOrder find_elimination_order(const Encoding& encoding, int threads, const Execution& execution);

/// The free vertices' slots in that order. @param order all vertices.
std::vector<Index> slots_in_order(const std::vector<Index>& order, const Unknowns& unknowns);

/// Slots in an order of their own, along the parts of the whole mesh: for a coarser mesh of some of its vertices,
/// whose rows couple others. @param lower the matrix to be factored. @throws Cancelled.
std::vector<Index> order_along(const RegionOrder& whole, const SparseMatrix& lower, const Unknowns& unknowns,
                               int threads, const Execution& execution);

}  // namespace meanvalue
