// Which points are as good as one: in one place, or nearly.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// For each point the lowest of those that steps of at most `distance` lead to; itself for one that is not finite.
/// Where more than a few points are nearer together than that, those that are outermost along the axes stand for all
/// in steps to others, so that the cost is that of sorting.
/// @param points n x 3; distance at least 0, in their units. @throws InvalidInput, Cancelled.
std::vector<Index> first_of_place(const PositionsView& points, double distance, const Execution& execution);

}  // namespace meanvalue
