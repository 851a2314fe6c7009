// Rotations as vectors: their axis times their angle, also beyond half a turn.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// The rotation by |vector| about it (Rodrigues). Any length. The same bits on every processor.
Matrix3 rotation_by(const Vector3& vector);

/// The vector of a rotation that is nearest to `near`: its angle may be beyond half a turn, or several turns.
/// @param rotation orthogonal to rounding, determinant 1.
Vector3 rotation_vector(const Matrix3& rotation, const Vector3& near = Vector3::Zero());

/// The rotation by the average of `count` vectors. @param frames a rotation for each, which comes after it; or none.
Matrix3 average_turn(const Vector3* vectors, const std::vector<Matrix3>& frames, const double* weights, Index count);

}  // namespace meanvalue
