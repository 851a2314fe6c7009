#include "meanvalue/mesh/closest_point.h"

#include <algorithm>
#include <limits>

namespace meanvalue {
namespace {

/// How far along the segment, from 0 to 1.
double along_segment(const Vector3& from, const Vector3& to, const Vector3& point) {
    const Vector3 edge = to - from;
    const double square = edge.squaredNorm();
    return square > 0.0 ? std::clamp((point - from).dot(edge) / square, 0.0, 1.0) : 0.0;
}

}  // namespace

Vector3 closest_point(const std::array<Vector3, 3>& corners, const Vector3& point) {
    const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double square = normal.squaredNorm();
    if (square > 0.0) {
        Vector3 weights;
        for (int c = 0; c < 3; ++c) {
            const Vector3& next = corners[(c + 1) % 3];
            weights(c) = (corners[(c + 2) % 3] - next).cross(point - next).dot(normal) / square;
        }
        if (weights.minCoeff() >= 0.0 && weights.allFinite()) return weights / weights.sum();
    }
    Vector3 nearest = Vector3::UnitX();
    double least = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
        const int next = (c + 1) % 3;
        const double share = along_segment(corners[c], corners[next], point);
        const double distance = ((1.0 - share) * corners[c] + share * corners[next] - point).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        nearest.setZero();
        nearest(c) = 1.0 - share;
        nearest(next) = share;
    }
    return nearest;
}

}  // namespace meanvalue
