// Where the surface of a mesh ends.
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

}  // namespace meanvalue
