#include "meanvalue/encoding/mean_value_weights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

// Sums of |w| are 1.0 to 1.1 on sane rings and up to 3.2 at the corners of open ones.
constexpr double kLargestAmplification = 4.0;

}  // namespace

std::uint8_t mean_value_weights(const ProjectedRing& ring, std::vector<double>& weights) {
    const std::size_t valence = ring.radius.size();
    weights.assign(valence, 0.0);
    const std::size_t nearest = std::min_element(ring.radius.begin(), ring.radius.end()) - ring.radius.begin();
    if (ring.radius[nearest] < kCoincident * ring.mean_radius) {
        weights[nearest] = 1.0;
        return kOnRingVertex;
    }
    for (std::size_t k = 0; k < valence; ++k) {
        const std::size_t next = (k + 1) % valence;
        const double product = ring.radius[k] * ring.radius[next];
        const double dot = ring.tangential[k].dot(ring.tangential[next]);
        const double cross = ring.normal.dot(ring.tangential[k].cross(ring.tangential[next]));
        // The tangent of half the angle divides by 1 + cos(angle), or where that cancels by sin(angle). Where both
        // are nothing, the vertex is on the line between two ring vertices.
        double half_tangent = 0.0;
        if (product + dot > kNegligible * product) {
            half_tangent = cross / (product + dot);
        } else if (std::abs(cross) > kNegligible * product) {
            half_tangent = (product - dot) / cross;
        } else {
            std::fill(weights.begin(), weights.end(), 0.0);
            const double length = ring.radius[k] + ring.radius[next];
            weights[k] = ring.radius[next] / length;
            weights[next] = ring.radius[k] / length;
            return kOnRingEdge;
        }
        weights[k] += half_tangent / ring.radius[k];
        weights[next] += half_tangent / ring.radius[next];
    }
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (double& weight : weights)
        weight /= sum;
    return 0;
}

bool weights_are_tame(const std::vector<double>& weights) {
    double amplification = 0.0;
    for (const double weight : weights)
        amplification += std::abs(weight);
    return amplification <= kLargestAmplification;  // false for NaN too
}

void least_norm_weights(const ProjectedRing& ring, std::vector<double>& weights) {
    // Correct 1/m by the shortest vector d with sum d = 0 and sum d_j T_j = -sum T_j / m.
    const Eigen::Index valence = static_cast<Eigen::Index>(ring.radius.size());
    const Vector3 axis_u = ring.normal.unitOrthogonal();
    const Vector3 axis_v = ring.normal.cross(axis_u);
    Eigen::Matrix<double, 3, Eigen::Dynamic> conditions(3, valence);
    Vector3 sum = Vector3::Zero();
    for (Eigen::Index j = 0; j < valence; ++j) {
        const Vector3 scaled = ring.tangential[j] / ring.mean_radius;
        conditions.col(j) << 1.0, axis_u.dot(scaled), axis_v.dot(scaled);
        sum += conditions.col(j);
    }
    const double uniform = 1.0 / static_cast<double>(valence);
    const Vector3 wanted(1.0, 0.0, 0.0);
    const Vector3 missing = wanted - sum * uniform;
    const auto solver = conditions.completeOrthogonalDecomposition();
    Eigen::VectorXd result = solver.solve(missing).array() + uniform;
    result += solver.solve(wanted - conditions * result);  // one refinement: reproduction to rounding
    weights.assign(result.data(), result.data() + valence);
}

}  // namespace meanvalue
