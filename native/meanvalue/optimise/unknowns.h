// Which vertices are solved for, and which rows of the energy depend on them.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// The free vertices V' of equation 15 and the part of the mesh that they touch. Everything else keeps its
/// place and takes no part in a solve, so that the cost depends on the free vertices alone.
struct Unknowns {
    std::vector<Index> free;    ///< vertex numbers, ascending
    std::vector<Index> number;  ///< n: of a free vertex in `free`; -1 for a fixed one
    std::vector<Index> rows;    ///< vertices i whose residual v_i - F_i(V) depends on a free vertex, ascending
};

/// A row depends on its vertex and on that vertex's ring; a vertex with an empty ring has no row.
/// @param ring_offsets n + 1, ring: the rings one after another; @param is_fixed n flags.
Unknowns find_unknowns(const std::vector<Index>& ring_offsets, const std::vector<Index>& ring,
                       const std::vector<char>& is_fixed);

inline Unknowns find_unknowns(const Encoding& encoding, const std::vector<char>& is_fixed) {
    return find_unknowns(encoding.ring_offsets, encoding.ring, is_fixed);
}

/// A place in the ring of a row, by its number in Unknowns::rows.
struct Use {
    Index row;
    Index place;
};

/// Where each of the n vertices is in the rings of the rows, by ascending row. @throws Cancelled.
Grouped<Use> uses_of(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution);

}  // namespace meanvalue
