#include "meanvalue/morph/rotation_vectors.h"

#include <Eigen/LU>
#include <cmath>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

constexpr double kFullAngle = 6.28318530717958647692;
constexpr int kMeanRounds = 8;
constexpr double kMeanTolerance = 1e-9;
constexpr double kFarStep = 1.0;  // radians; slopes are singular not far beyond
constexpr double kSmallAngle = 1e-6;

/// Minus the derivative of the vector of R exp(-s) by s at 0, without the part that cancels in a sum of zero.
Matrix3 slope_of(const Vector3& vector) {
    const double angle = vector.norm();
    if (angle < kSmallAngle) return Matrix3::Identity();
    const SineCosine half = sine_cosine(0.5 * angle);
    const double across = 0.5 * angle * half.cosine / half.sine;
    const Vector3 axis = vector / angle;
    return across * Matrix3::Identity() + (1.0 - across) * axis * axis.transpose();
}

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

Matrix3 rotation_by(const Vector3& vector) {
    return quaternion_by(vector).toRotationMatrix();
}

/// By its largest entry (Shepperd 1978).
Quaternion quaternion_of(const Matrix3& r) {
    const double trace = r.trace();
    Eigen::Vector4d q;  // w, x, y, z
    if (trace >= r.diagonal().maxCoeff()) {
        q << 1.0 + trace, r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1);
    } else {
        Eigen::Index i = 0;
        r.diagonal().maxCoeff(&i);
        const Eigen::Index j = (i + 1) % 3;
        const Eigen::Index k = (i + 2) % 3;
        q(0) = r(k, j) - r(j, k);
        q(1 + i) = 1.0 + r(i, i) - r(j, j) - r(k, k);
        q(1 + j) = r(j, i) + r(i, j);
        q(1 + k) = r(k, i) + r(i, k);
    }
    q /= q.norm();
    return {q(0), q(1), q(2), q(3)};
}

Vector3 rotation_vector(const Matrix3& rotation, const Vector3& near) {
    return rotation_vector(quaternion_of(rotation), near);
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

Quaternion average_rotation(const Vector3* vectors, const std::vector<Quaternion>& frames, const double* weights,
                            Index count) {
    Vector3 sum = Vector3::Zero();
    for (Index k = 0; k < count; ++k) {
        if (weights[k] == 0.0) continue;
        sum += weights[k] *
               (frames.empty() ? vectors[k] : rotation_vector(frames[k] * quaternion_by(vectors[k]), vectors[k]));
    }
    return quaternion_by(sum);
}

Matrix3 centre_rotations(Matrix3* rotations, Vector3* vectors, Index count) {
    Matrix3 factor = Matrix3::Identity();
    for (int round = 0; round < kMeanRounds; ++round) {
        Vector3 mean = Vector3::Zero();
        Matrix3 slope = Matrix3::Zero();
        for (Index k = 0; k < count; ++k) {
            mean += vectors[k] / count;
            slope += slope_of(vectors[k]) / count;
        }
        if (mean.norm() < kMeanTolerance) break;
        const Vector3 newton = slope.inverse() * mean;
        const Matrix3 step =
            rotation_by(newton.norm() < kFarStep ? newton : mean);  // else the mean, also where Newton gives NaN
        factor = step * factor;
        for (Index k = 0; k < count; ++k) {
            rotations[k] = rotations[k] * step.transpose();
            vectors[k] = rotation_vector(rotations[k], vectors[k] - mean);
        }
    }
    return factor;
}

}  // namespace meanvalue
