// The plane into which a vertex and its ring are projected: paper, equations 1 to 4.
#pragma once

#include "meanvalue/common/types.h"

namespace meanvalue {

/// The ring's normal before and after normalisation.
///
/// Orientation: the paper's (next x current) points inwards for a counter-clockwise ring; we sum
/// (current x next), which points outwards. The cotangents b change sign with it, the predictor does not.
struct RingNormal {
    Vector3 area = Vector3::Zero();    ///< twice the vector area of the ring polygon (equation 2, numerator)
    Vector3 normal = Vector3::Zero();  ///< of unit length; zero where the ring encloses no area
    double length = 0.0;               ///< |area|; zero where the normal is
};

// Below this share of the squared perimeter, a ring's area is rounding noise and its normal means nothing.
// Only a deformed ring can come this low: the encoder wants kMinimalRingArea of the rest shape.
constexpr double kVanishingRingArea = 1e-12;

/// Sums the area of the closed polygon over ring vertices. Linear in the valence; a ring's centroid cancels
/// out of the sum (equation 3), so the first ring vertex serves as origin.
inline RingNormal ring_normal(const PositionsView& positions, const Index* ring, Index valence) {
    RingNormal result;
    if (valence < 3) return result;
    const Vector3 origin = positions.row(ring[0]);
    double squared_lengths = 0.0;
    Vector3 current = Vector3::Zero();
    for (Index k = 1; k < valence; ++k) {
        const Vector3 next = Vector3(positions.row(ring[k])) - origin;
        result.area += current.cross(next);
        squared_lengths += next.squaredNorm();
        current = next;
    }
    const double length = result.area.norm();
    if (length > kVanishingRingArea * squared_lengths) {
        result.length = length;
        result.normal = result.area / length;
    }
    return result;
}

}  // namespace meanvalue
