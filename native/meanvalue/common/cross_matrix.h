// The cross product as a matrix.
#pragma once

#include "meanvalue/common/types.h"

namespace meanvalue {

/// [v]_x: cross_matrix(v) * x = v x x.
inline Matrix3 cross_matrix(const Vector3& v) {
    Matrix3 matrix;
    matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    return matrix;
}

}  // namespace meanvalue
