// The cells whose lengths rigidity keeps: each vertex with the edges of its ring at rest, and what each edge counts.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// The edges p_i - p_k of every vertex i to its ring, in the order of Encoding::ring. The frame of a cell has the
/// ring's normal for its z and the first edge in its x-z plane, so that cells of several shapes of one mesh may be
/// averaged edge by edge, however these are rotated.
struct RestCells {
    std::vector<Vector3> edges;  ///< |Encoding::ring|
    /// The mean length of a cell's edges; 0 without any.
    double mean_edge(const Encoding& encoding, Index vertex) const;
};

/// @param rest n x 3. The same bits for any `threads`. @throws Cancelled. Cost: linear.
RestCells rest_cells(const Encoding& encoding, const PositionsView& rest, int threads, const Execution& execution);

/// An edge of a cell, with what it counts in keeping lengths.
struct Spoke {
    Vector3 rest;  ///< p_i - p_k, in the frame of the cell
    double spoke;  ///< c_ik, its cotangent weight
    double rim;    ///< c_kl of the edge from k to l, the next in the ring
};

/// @param edges `valence` of them, RestCells::edges of i. @param spokes receives as many. @return their mean length.
double measure_spokes(const Vector3* edges, Index valence, Spoke* spokes);

/// How many times keeping lengths counts in a cell: the more, the more it is curved. @param size of the shape.
double rigidity_of_cell(const Vector3* edges, Index valence, double size);

}  // namespace meanvalue
