// Where the surface of a mesh ends, and where it goes on all the same.
#pragma once

#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// The edges that one face alone has, the lower vertex first, ascending.
/// @param corners vertices of faces, of `count`, one face after another. @param starts where each begins in it.
/// @throws InvalidInput, Cancelled.
std::vector<std::pair<Index, Index>> border_edges(Index count, const std::vector<Index>& corners,
                                                  const std::vector<Index>& starts, const Execution& execution);

/// For each vertex the lowest that it is one with, no double's if it can: those of borders in one place are, and a
/// double: a piece from there on that lies on others with all its vertices. What is given is as of the others.
std::vector<Index> first_of_seams(const PositionsView& points, const std::vector<Index>& corners,
                                  const std::vector<Index>& starts, double distance, const Execution& execution);

}  // namespace meanvalue
