// The plane into which a vertex and its ring are projected: paper, equations 1 to 4.
#pragma once

#include <cmath>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// What a ring polygon encloses, and how large it is.
///
/// Orientation: the paper's (next x current) points inwards for a counter-clockwise ring; we sum
/// (current x next), which points outwards. The cotangents b change sign with it, the predictor does not.
struct RingArea {
    Vector3 area = Vector3::Zero();    ///< twice the vector area of the ring polygon (equation 2, numerator)
    Vector3 centre = Vector3::Zero();  ///< mean of the ring vertices (equation 3)
    double spread = 0.0;               ///< sum of squared distances from the centre
};

/// Linear in the valence. Summed about the first ring vertex, so that nothing is lost far from the origin.
inline RingArea ring_area(const PositionsView& positions, const Index* ring, Index valence) {
    RingArea result;
    const Vector3 origin = positions.row(ring[0]);
    Vector3 sum = Vector3::Zero();
    double squares = 0.0;
    Vector3 current = Vector3::Zero();
    for (Index k = 1; k < valence; ++k) {
        const Vector3 next = Vector3(positions.row(ring[k])) - origin;
        result.area += current.cross(next);
        sum += next;
        squares += next.squaredNorm();
        current = next;
    }
    result.centre = origin + sum / valence;
    result.spread = squares - sum.squaredNorm() / valence;
    return result;
}

// How far, as a share of its rest area, a ring must fold up before its normal is softened noticeably.
constexpr double kSoftness = 1e-2;
// 1 / sqrt(1 + kSoftness^2): how long every soft normal is at rest, whatever the ring.
const double kRestNormalLength = 1.0 / std::sqrt(1.0 + kSoftness * kSoftness);
// A steep ring's own height, n . sum_j (u_j - w_j) v_j, is seen along the soft normal and put along it again.
constexpr double kSteepScale = 1.0 + kSoftness * kSoftness;

/// The normal that the predictor uses: n = N / sqrt(|N|^2 + (softening * spread)^2).
///
/// The paper's n = N / |N| jumps to its opposite where a deformed ring folds flat (N = 0), and a descent cannot
/// pass such a cliff. This one goes through zero instead. It is of length kRestNormalLength at rest, for
/// which the encoder makes up, and scales with the mesh.
struct SoftNormal {
    Vector3 normal = Vector3::Zero();
    double length = 0.0;  ///< sqrt(|N|^2 + (softening * spread)^2); zero where the ring is a point
};

inline SoftNormal soft_normal(const RingArea& ring, double softening) {
    SoftNormal result;
    const double floor = softening * ring.spread;
    result.length = std::sqrt(ring.area.squaredNorm() + floor * floor);
    if (result.length > 0.0) result.normal = ring.area / result.length;
    return result;
}

}  // namespace meanvalue
