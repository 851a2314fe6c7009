// The smallest set of vertices that separates two parts of a graph.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

enum class Side : std::uint8_t { kLeft, kRight, kBetween };

/// The fewest vertices without which no path leads from the left end to the right, of several such sets the one
/// nearest to the left: by Menger's theorem there are as many paths without a common vertex, which are a maximum flow
/// (E. A. Dinic, Algorithm for solution of a problem of maximum flow in networks, Soviet Math. Doklady 11, 1970).
/// @param left_end vertices below it are on the left, @param right_begin those from it on are on the right; both may
/// be taken into the separator as well. Fastest where neighbors have numbers near each other.
/// @return the side of each vertex, kBetween for those of the separator; no edge joins left and right.
/// @throws Cancelled.
std::vector<Side> minimum_separator(const Graph& graph, Index left_end, Index right_begin,
                                    const Execution& execution);

}  // namespace meanvalue
