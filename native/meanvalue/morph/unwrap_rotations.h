// Phase unwrapping for rotation vectors: their angles beyond 180 degrees, where limbs turn so far.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// The vectors of all rotations, on branches that are followed over the mesh: from the cell that is rotated
/// least on, each from the neighbor that is rotated the most alike. The order of shapes does not matter.
/// @param layout the rings, n. @param rotations n x k. @return n x k. @throws Cancelled. Cost: O(n k log n).
std::vector<Vector3> unwrap_rotations(const Encoding& layout, const std::vector<Matrix3>& rotations,
                                      Index shape_count, const Execution& execution);

}  // namespace meanvalue
