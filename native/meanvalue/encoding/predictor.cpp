#include "meanvalue/encoding/predictor.h"

#include <Eigen/Geometry>

#include "meanvalue/common/cross_matrix.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

/// p = sum_j w_j v_j, summed about the first ring vertex so that nothing is lost far from the origin.
Vector3 weighted_centre(const EncodedRing& ring, const PositionsView& positions) {
    const Vector3 origin = positions.row(ring.ring[0]);
    Vector3 sum = Vector3::Zero();
    for (Index k = 1; k < ring.valence; ++k) {
        sum += ring.weights[k] * (Vector3(positions.row(ring.ring[k])) - origin);
    }
    return origin + sum;
}

/// q = sum_j (u_j - w_j) v_j: how far a steep ring's own centre is from p.
Vector3 steep_offset(const EncodedRing& ring, const PositionsView& positions) {
    const Vector3 origin = positions.row(ring.ring[0]);
    Vector3 sum = Vector3::Zero();
    for (Index k = 1; k < ring.valence; ++k) {
        const double difference = ring.normal_weights[k] - ring.weights[k];
        sum += difference * (Vector3(positions.row(ring.ring[k])) - origin);
    }
    return sum;
}

/// F_i and what its derivatives by all ring vertices have in common.
class RingLinearisation {
  public:
    /// @param keep is called with each k and dl_k/dD_k: the direction of T_k, less its part along the normal.
    template <typename Keep>
    RingLinearisation(const EncodedRing& ring, const PositionsView& positions, const Keep& keep)
        : ring_(ring),
          positions_(positions),
          centre_(weighted_centre(ring, positions)),
          polygon_(ring_area(positions, ring.ring, ring.valence)),
          plane_(soft_normal(polygon_, ring.softening)) {
        const Vector3& normal = plane_.normal;
        for (Index k = 0; k < ring.valence; ++k) {
            const Vector3 difference = centre_ - Vector3(positions.row(ring.ring[k]));
            const double along = normal.dot(difference);
            const Vector3 tangential = difference - along * normal;
            const double length = tangential.norm();
            const Vector3 direction = length > 0.0 ? Vector3(tangential / length) : Vector3::Zero();
            const double lean = direction.dot(normal);  // zero but for the softening
            const Vector3 length_gradient = direction - lean * normal;
            offset_ += ring.heights[k] * length;
            pull_ += ring.heights[k] * length_gradient;
            tilt_ -= ring.heights[k] * (along * direction + lean * difference);
            keep(k, length_gradient);
        }
        if (ring.normal_weights != nullptr) {
            const Vector3 difference = kSteepScale * steep_offset(ring, positions);
            offset_ += normal.dot(difference);
            tilt_ += difference;
        }
    }

    /// Must be called before the first block().
    void prepare_blocks() {
        if (plane_.length == 0.0) return;
        // dF/dn = s I + n tilt^T; dn = ((I - n n^T) dN - n softening^2 spread / length dspread) / length
        const Vector3& normal = plane_.normal;
        const Matrix3 by_normal = offset_ * Matrix3::Identity() + normal * tilt_.transpose();
        by_area_ = by_normal * (Matrix3::Identity() - normal * normal.transpose()) / plane_.length;
        by_spread_ = by_normal * normal * spread_share();
    }

    Vector3 predicted() const { return centre_ + offset_ * plane_.normal; }

    /// dF_i/dv_k.
    Matrix3 block(Index k, const Vector3& length_gradient) const {
        Vector3 offset_gradient = ring_.weights[k] * pull_ - ring_.heights[k] * length_gradient;
        if (ring_.normal_weights != nullptr) {
            offset_gradient += kSteepScale * (ring_.normal_weights[k] - ring_.weights[k]) * plane_.normal;
        }
        const Vector3 here = positions_.row(ring_.ring[k]);
        const Vector3 previous = positions_.row(ring_.ring[k == 0 ? ring_.valence - 1 : k - 1]);
        const Vector3 next = positions_.row(ring_.ring[k + 1 == ring_.valence ? 0 : k + 1]);
        return ring_.weights[k] * Matrix3::Identity() + plane_.normal * offset_gradient.transpose() +
               by_area_ * cross_matrix(previous - next) + by_spread_ * (2.0 * (here - polygon_.centre)).transpose();
    }

  private:
    /// The soft normal's change with the ring's spread, along itself.
    double spread_share() const {
        const double share = ring_.softening / plane_.length;
        return -share * share * polygon_.spread;
    }

    const EncodedRing& ring_;
    const PositionsView& positions_;
    Vector3 centre_;
    RingArea polygon_;
    SoftNormal plane_;
    double offset_ = 0.0;             // s
    Vector3 pull_ = Vector3::Zero();  // ds/dp
    Vector3 tilt_ = Vector3::Zero();  // ds/dn
    Matrix3 by_area_ = Matrix3::Zero();
    Vector3 by_spread_ = Vector3::Zero();
};

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
    // The blocks' memory holds each vertex' length gradient until its block is made.
    RingLinearisation linear(ring, positions,
                             [&](Index k, const Vector3& length_gradient) { blocks[k].col(0) = length_gradient; });
    linear.prepare_blocks();
    for (Index k = 0; k < ring.valence; ++k)
        blocks[k] = linear.block(k, Vector3(blocks[k].col(0)));
    return linear.predicted();
}

Vector3 predict_with_jacobian_of(const EncodedRing& ring, const PositionsView& positions, Index place,
                                 Matrix3& block) {
    Vector3 own_length_gradient;
    RingLinearisation linear(ring, positions, [&](Index k, const Vector3& length_gradient) {
        if (k == place) own_length_gradient = length_gradient;
    });
    linear.prepare_blocks();
    block = linear.block(place, own_length_gradient);
    return linear.predicted();
}

Positions predict_all(const Encoding& encoding, const PositionsView& positions, int threads,
                      const Execution& execution) {
    Positions predicted(positions.rows(), 3);
    parallel_for(encoding.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            if (encoding.predictable(v)) {
                predicted.row(v) = predict(encoding.ring_of(v), positions);
            } else {
                predicted.row(v) = positions.row(v);
            }
        }
    });
    return predicted;
}

double energy(const Encoding& encoding, const PositionsView& positions, int threads, const Execution& execution) {
    return 0.5 * (positions - predict_all(encoding, positions, threads, execution)).squaredNorm();
}

}  // namespace meanvalue
