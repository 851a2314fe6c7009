// The sparse matrices that are factored, and the graph of one, for which an order of elimination is found.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// 64-bit offsets: the factor of a million free vertices has more than 2^31 entries.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

/// The neighbours of each vertex. Undirected, without loops: each edge is in the list of both its ends.
using Graph = Grouped<Index>;

/// A vertex for each column, neighbours ascending. Only entries below the diagonal are looked at.
/// @throws Cancelled.
inline Graph graph_of(const SparseMatrix& lower, const Execution& execution) {
    return grouped<Index>(lower.cols(), [&](const auto& visit) {
        // Column after column: what comes before a vertex is in its list before what comes after it.
        for (Index column = 0; column < lower.cols(); ++column) {
            execution.check_every(column);
            for (SparseMatrix::InnerIterator entry(lower, column); entry; ++entry) {
                if (entry.row() <= column) continue;
                visit(entry.row(), column);
                visit(column, static_cast<Index>(entry.row()));
            }
        }
    });
}

}  // namespace meanvalue
