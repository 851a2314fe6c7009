// Which points are as good as one: in one place, or nearly; where a surface ends, and where it goes on all the same.
#pragma once

#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// For each point the lowest of those that steps of at most `distance` lead to; itself for one that is not finite.
/// Where more than a few points are nearer together than that, those that are outermost along the axes stand for all
/// in steps to others, so that the cost is that of sorting.
/// @param points n x 3; distance at least 0, in their units. @throws InvalidInput, Cancelled.
std::vector<Index> first_of_place(const PositionsView& points, double distance, const Execution& execution);

/// The edges that one face alone has, the lower vertex first, ascending.
/// @param corners vertices of faces, of `count`, one face after another. @param starts where each begins in it.
/// @throws InvalidInput, Cancelled.
std::vector<std::pair<Index, Index>> border_edges(Index count, const std::vector<Index>& corners,
                                                  const std::vector<Index>& starts, const Execution& execution);

/// For each vertex the lowest that it is one with, no double's if it can: those of borders in one place are, with the
/// first inside a surface there, as a wing is on its body; and a double: a piece from there on that lies on others
/// with all its vertices. What is given is as of the others.
std::vector<Index> first_of_seams(const PositionsView& points, const std::vector<Index>& corners,
                                  const std::vector<Index>& starts, double distance, const Execution& execution);

}  // namespace meanvalue
