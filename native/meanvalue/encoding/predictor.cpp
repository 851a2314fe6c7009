#include "meanvalue/encoding/predictor.h"

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

/// sum_j factor_of(j) (v_j - v_0): about the first ring vertex nothing is lost far from the origin.
template <typename FactorOf>
Vector3 sum_about_first(const EncodedRing& ring, const PositionsView& positions, const FactorOf& factor_of) {
    Vector3 sum = Vector3::Zero();
    for (Index k = 1; k < ring.valence; ++k)
        sum += factor_of(k) * Vector3(positions.row(ring.ring[k]) - positions.row(ring.ring[0]));
    return sum;
}

/// p = sum_j w_j v_j.
Vector3 weighted_centre(const EncodedRing& ring, const PositionsView& positions) {
    return Vector3(positions.row(ring.ring[0])) +
           sum_about_first(ring, positions, [&](Index k) { return ring.weights[k]; });
}

/// q = sum_j (u_j - w_j) v_j: how far a steep ring's own centre is from p.
Vector3 steep_offset(const EncodedRing& ring, const PositionsView& positions) {
    return sum_about_first(ring, positions, [&](Index k) { return ring.normal_weights[k] - ring.weights[k]; });
}

}  // namespace

Vector3 predict(const EncodedRing& ring, const PositionsView& positions) {
    const Vector3 normal = soft_normal(ring_area(positions, ring.ring, ring.valence), ring.softening).normal;
    const Vector3 centre = weighted_centre(ring, positions);
    double offset = 0.0;
    for (Index k = 0; k < ring.valence; ++k) {
        const Vector3 difference = centre - Vector3(positions.row(ring.ring[k]));
        offset += ring.heights[k] * (difference - normal.dot(difference) * normal).norm();
    }
    if (ring.normal_weights != nullptr) offset += kSteepScale * normal.dot(steep_offset(ring, positions));
    return centre + offset * normal;
}

Vector3 predict_with_jacobian(const EncodedRing& ring, const PositionsView& positions, Matrix3* blocks) {
    const Vector3 centre = weighted_centre(ring, positions);
    const RingArea polygon = ring_area(positions, ring.ring, ring.valence);
    const SoftNormal plane = soft_normal(polygon, ring.softening);
    const Vector3& normal = plane.normal;
    double offset = 0.0;             // s
    Vector3 pull = Vector3::Zero();  // ds/dp
    Vector3 tilt = Vector3::Zero();  // ds/dn
    for (Index k = 0; k < ring.valence; ++k) {
        const Vector3 difference = centre - Vector3(positions.row(ring.ring[k]));
        const double along = normal.dot(difference);
        const Vector3 tangential = difference - along * normal;
        const double length = tangential.norm();
        const Vector3 direction = length > 0.0 ? Vector3(tangential / length) : Vector3::Zero();
        const double lean = direction.dot(normal);  // zero but for the softening
        const Vector3 length_gradient = direction - lean * normal;
        offset += ring.heights[k] * length;
        pull += ring.heights[k] * length_gradient;
        tilt -= ring.heights[k] * (along * direction + lean * difference);
        blocks[k].col(0) = length_gradient;  // until the block is made
    }
    if (ring.normal_weights != nullptr) {
        const Vector3 difference = kSteepScale * steep_offset(ring, positions);
        offset += normal.dot(difference);
        tilt += difference;
    }
    Matrix3 by_area = Matrix3::Zero();
    Vector3 by_spread = Vector3::Zero();
    if (plane.length > 0.0) {
        // dF/dn = s I + n tilt^T; dn = ((I - n n^T) dN - n softening^2 spread / length dspread) / length
        const Matrix3 by_normal = offset * Matrix3::Identity() + normal * tilt.transpose();
        const double share = ring.softening / plane.length;
        by_area = by_normal * (Matrix3::Identity() - normal * normal.transpose()) / plane.length;
        by_spread = by_normal * normal * (-share * share * polygon.spread);
    }
    for (Index k = 0; k < ring.valence; ++k) {
        const Vector3 length_gradient = blocks[k].col(0);
        Vector3 offset_gradient = ring.weights[k] * pull - ring.heights[k] * length_gradient;
        if (ring.normal_weights != nullptr)
            offset_gradient += kSteepScale * (ring.normal_weights[k] - ring.weights[k]) * normal;
        const Vector3 here = positions.row(ring.ring[k]);
        const Vector3 previous = positions.row(ring.ring[k == 0 ? ring.valence - 1 : k - 1]);
        const Vector3 next = positions.row(ring.ring[k + 1 == ring.valence ? 0 : k + 1]);
        blocks[k] = ring.weights[k] * Matrix3::Identity() + normal * offset_gradient.transpose() +
                    by_area * cross_matrix(previous - next) + by_spread * (2.0 * (here - polygon.centre)).transpose();
    }
    return centre + offset * normal;
}

Positions predict_all(const Encoding& encoding, const PositionsView& positions, int threads,
                      const Execution& execution) {
    Positions predicted = positions;
    parallel_for(encoding.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            if (encoding.predictable(v)) predicted.row(v) = predict(encoding.ring_of(v), positions);
        }
    });
    return predicted;
}

double energy(const Encoding& encoding, const PositionsView& positions, int threads, const Execution& execution) {
    return 0.5 * (positions - predict_all(encoding, positions, threads, execution)).squaredNorm();
}

}  // namespace meanvalue
