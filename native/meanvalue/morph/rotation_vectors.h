// Rotations as vectors: their axis times their angle, also beyond 180 degrees.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// A unit quaternion; q and -q are the same rotation.
using Quaternion = Eigen::Quaterniond;

/// The rotation by |vector| about it. Any length. The same bits on every processor.
Quaternion quaternion_by(const Vector3& vector);

/// The vector of a rotation that is nearest to `near`: its angle may be beyond 180 degrees, or several times 360.
Vector3 rotation_vector(const Quaternion& rotation, const Vector3& near = Vector3::Zero());

/// From the frame of a cell to one half-way to a neighbor's. Beyond 90 degrees between them it goes back to the
/// cell's own, so that it is smooth also where half-way is ambiguous.
Quaternion half_way(const Quaternion& own, const Quaternion& other);

/// The rotation nearest to every `stride`th of the rotations from `first` on (least squares of their matrices).
Quaternion nearest_to_all(const std::vector<Quaternion>& rotations, std::size_t first = 0, std::size_t stride = 1);

/// The average of rotations, by their vectors from the one nearest to all. @param weights sum to one.
Quaternion mean_of_rotations(const std::vector<Quaternion>& rotations, const std::vector<double>& weights);

/// The rotation by the average of `count` vectors. @param frames a rotation for each, which comes after it; or none.
Quaternion average_rotation(const Vector3* vectors, const std::vector<Quaternion>& frames, const double* weights,
                            std::size_t count);

}  // namespace meanvalue
