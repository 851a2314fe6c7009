// A small set of vertices that cuts a graph into two parts of about the same size.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

enum class Side : std::uint8_t { kLeft, kRight, kBetween };

/// Cuts the graph where it is thin between two of its ends.
/// @param graph connected, of two vertices or more. Best where the last vertex is far from the first, as in
/// breadth-first order.
/// @return the side of each vertex, kBetween for those of the separator; no edge joins left and right.
/// @throws Cancelled. Cost: about linear.
std::vector<Side> balanced_separator(const Graph& graph, const Execution& execution);

}  // namespace meanvalue
