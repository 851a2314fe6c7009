#include "meanvalue/morph/rotation_vectors.h"

#include <cmath>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

constexpr double kFullAngle = 6.28318530717958647692;

}  // namespace

Quaternion quaternion_by(const Vector3& vector) {
    const double angle = vector.norm();
    if (angle == 0.0) return Quaternion::Identity();
    const SineCosine half = sine_cosine(0.5 * angle);
    Quaternion result;
    result.w() = half.cosine;
    result.vec() = half.sine / angle * vector;
    return result;
}

Vector3 rotation_vector(const Quaternion& rotation, const Vector3& near) {
    const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
    const Vector3 imaginary = sign * rotation.vec();
    const double sine = imaginary.norm();
    const double angle = 2.0 * arc_tangent(sine, sign * rotation.w());
    const double near_length = near.norm();
    Vector3 axis = Vector3::Zero();
    if (sine > kRounding) {
        axis = imaginary / sine;
    } else if (near_length > 0.0) {
        axis = near / near_length;
    }
    // Of the angles that differ by whole rotations, the one nearest to `near`.
    const double turns = std::floor((near.dot(axis) - angle) / kFullAngle + 0.5);
    return (angle + turns * kFullAngle) * axis;
}

Quaternion half_way(const Quaternion& own, const Quaternion& other) {
    Quaternion relative = own.conjugate() * other;
    const double cosine = relative.w();
    relative.vec() *= cosine;
    relative.w() = 1.0 + cosine * cosine;
    return relative.normalized();
}

Quaternion nearest_to_all(const std::vector<Quaternion>& rotations, std::size_t first, std::size_t stride) {
    Matrix3 sum = Matrix3::Zero();
    for (std::size_t k = first; k < rotations.size(); k += stride)
        sum += rotations[k].toRotationMatrix();
    return Quaternion(closest_rotation(sum));
}

Quaternion mean_of_rotations(const std::vector<Quaternion>& rotations, const std::vector<double>& weights) {
    const Quaternion middle = nearest_to_all(rotations);
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < rotations.size(); ++k)
        sum += weights[k] * rotation_vector(rotations[k] * middle.conjugate());
    return quaternion_by(sum) * middle;
}

Quaternion average_rotation(const Vector3* vectors, const std::vector<Quaternion>& frames, const double* weights,
                            std::size_t count) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        if (weights[k] == 0.0) continue;
        sum += weights[k] *
               (frames.empty() ? vectors[k] : rotation_vector(frames[k] * quaternion_by(vectors[k]), vectors[k]));
    }
    return quaternion_by(sum);
}

}  // namespace meanvalue
