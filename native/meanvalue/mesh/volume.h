// What is inside a closed shape.
#pragma once

#include "meanvalue/common/types.h"

namespace meanvalue {

/// In cubed units; below 0 for a shape that is inside out. @param positions n x 3, at least one. Cost: linear.
double signed_volume(const PositionsView& positions, const TrianglesView& faces);

/// Whether the triangles' areas, as vectors, cancel each other, as those of shapes without a border do.
/// @param positions n x 3. Cost: linear.
bool is_closed(const PositionsView& positions, const TrianglesView& faces);

}  // namespace meanvalue
