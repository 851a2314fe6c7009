// Which vertices are solved for, and which rows of the energy depend on them.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// The free vertices V' of equation 15 and the part of the mesh that they touch. Everything else keeps its
/// place and takes no part in a solve, so that the cost depends on the free vertices alone.
struct Unknowns {
    std::vector<Index> free;  ///< vertex numbers, ascending
    std::vector<Index> slot;  ///< n: position in `free`, -1 for a fixed vertex
    std::vector<Index> rows;  ///< vertices i whose residual v_i - F_i(V) depends on a free vertex, ascending
};

/// @param is_fixed n flags.
Unknowns find_unknowns(const Encoding& encoding, const std::vector<char>& is_fixed);

}  // namespace meanvalue
