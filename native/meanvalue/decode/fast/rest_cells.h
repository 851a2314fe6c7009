// The cells whose lengths rigidity keeps: each vertex with the edges of its ring at rest, in a frame of its own.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// The edges p_i - p_k of every vertex i to its ring, in the order of Encoding::ring. The frame of a cell has the
/// ring's normal for its z and the first edge in its x-z plane, so that cells of several shapes of one mesh may be
/// averaged edge by edge, however these are turned.
struct RestCells {
    std::vector<Vector3> edges;  ///< |Encoding::ring|
    /// The mean length of a cell's edges; 0 without any.
    double mean_edge(const Encoding& encoding, Index vertex) const;
};

/// @param rest n x 3. The same bits for any `threads`. @throws Cancelled. Cost: linear.
RestCells rest_cells(const Encoding& encoding, const PositionsView& rest, int threads, const Execution& execution);

}  // namespace meanvalue
