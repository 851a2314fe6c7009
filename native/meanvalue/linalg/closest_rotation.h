// The rotation nearest to a 3 x 3 matrix, fast enough to be found for every vertex in every step.
#pragma once

#include "meanvalue/common/types.h"

namespace meanvalue {

/// The rotation R that maximizes trace(R^T M), as fit_rotation() gives it, several times as fast: the largest
/// eigenvalue of the 4 x 4 quaternion matrix by Newton's method, its eigenvector by cofactors (Horn 1987; Theobald
/// 2005). Where that is ill-conditioned (rank one, or nearly a reflection of a flat star), by fit_rotation().
/// The identity for the zero matrix, and where an entry is not a finite number.
Matrix3 closest_rotation(Matrix3 matrix);

/// The same of `count` matrices, in their place; four take as long as one.
void closest_rotations(Matrix3* matrices, Index count);

}  // namespace meanvalue
