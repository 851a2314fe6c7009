// The point of a triangle that is nearest to another one.
#pragma once

#include <array>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// @return the weights of the corners, 0 or more and summing to 1, for the point of the triangle nearest to `point`;
/// triangles without area are the segment or point that they are.
Vector3 closest_point(const std::array<Vector3, 3>& corners, const Vector3& point);

}  // namespace meanvalue
