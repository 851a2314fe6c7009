// Which rings are too long to be solved for: one rule for all methods, to be asked before anything big is made.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// Free neighbors of one vertex at most. Each pair of them is coupled: the matrix has a dense block, and a
/// factorization of it takes the cube. Some seconds at this.
constexpr Index kMostNeighbours = 2048;

/// @param vertices as the caller of the whole knows them. @param neighbours of each: how many of them are free.
/// @throws InvalidInput that names the vertex with most neighbors, and how to mend it.
void require_short_rings(const std::vector<Index>& vertices, const std::vector<Index>& neighbours);

/// The same of the one-rings of a region, by the numbers of triangles: where several fans meet at a vertex, as if
/// they were one. @param is_fixed of the region's vertices. @throws Cancelled as well. Cost: linear.
void require_short_rings(const Region& region, const std::vector<char>& is_fixed, const Execution& execution);

}  // namespace meanvalue
