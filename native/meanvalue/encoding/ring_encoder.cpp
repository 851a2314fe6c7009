#include "meanvalue/encoding/ring_encoder.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

// An edge less than about 3 degrees off the normal: its b is unbounded, so the u_ij form takes over.
constexpr double kSteepestCotangent = 20.0;
// Sums of |w| are 1.0 to 1.1 on sane rings and up to 3.2 at the corners of open ones.
constexpr double kLargestAmplification = 4.0;

constexpr int kWidestExtension = 3;
// Of a neighbor with more neighbors than this, so many are taken, spread over its ring: where many vertices share one
// in a collapsed place, each would have a ring of them all.
constexpr std::ptrdiff_t kMostOfNeighbour = 32;

/// The direction in which the points vary least. Its sign is arbitrary: reversing it reverses the ring, its
/// normal and the heights alike, and the predictor stays the same.
Vector3 plane_normal(const PositionsView& positions, const std::vector<Index>& points, const Vector3& centroid) {
    Matrix3 covariance = Matrix3::Zero();
    for (const Index v : points) {
        const Vector3 offset = Vector3(positions.row(v)) - centroid;
        covariance += offset * offset.transpose();
    }
    return Eigen::SelfAdjointEigenSolver<Matrix3>(covariance).eigenvectors().col(0);
}

std::vector<Index> sorted_by_angle(const PositionsView& positions, const std::vector<Index>& points) {
    const Vector3 centroid = mean_row(positions(points, Eigen::all));
    const Vector3 normal = plane_normal(positions, points, centroid);
    const Vector3 axis_u = normal.unitOrthogonal();
    const Vector3 axis_v = normal.cross(axis_u);
    std::vector<std::pair<double, std::size_t>> angles;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vector3 offset = Vector3(positions.row(points[k])) - centroid;
        angles.emplace_back(arc_tangent(axis_v.dot(offset), axis_u.dot(offset)), k);
    }
    std::sort(angles.begin(), angles.end());
    std::vector<Index> sorted;
    sorted.reserve(angles.size());
    for (const auto& [angle, k] : angles)
        sorted.push_back(points[k]);
    return sorted;
}

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

std::uint8_t RingEncoder::encode(Index vertex, const Index* ring, Index valence) {
    project(vertex, ring, valence);
    if (projected_.normal.isZero(0.0)) return kNotPredictable;
    // The predictor must give the rest position back to rounding with mean-value weights, or least-norm weights are
    // tried; these may miss it by what is negligible.
    std::uint8_t flags = mean_value_weights(projected_, weights_);
    if (!weights_are_tame(weights_) || tangential_error() > kRounding * projected_.largest_radius) {
        least_norm_weights(projected_, weights_);
        flags = kLargeWeights;
        if (!(tangential_error() < kNegligible * projected_.largest_radius)) return kNotPredictable;
    }
    if (needs_own_normal_weights(flags)) flags |= kSteepEdge;
    fill_heights(flags);
    return flags;
}

std::vector<double> RingEncoder::steep_weights() const {
    std::vector<double> result;
    result.reserve(projected_.radius.size());
    for (const double radius : projected_.radius)
        result.push_back(radius / radius_sum_);
    return result;
}

void RingEncoder::project(Index vertex, const Index* ring, Index valence) {
    const RingArea polygon = ring_area(positions_, ring, valence);
    projected_.normal = polygon.area.normalized();
    softening_ = kSoftness * polygon.area.norm() / polygon.spread;
    projected_.tangential.resize(valence);
    projected_.radius.resize(valence);
    projected_.height.resize(valence);
    projected_.largest_radius = 0.0;
    radius_sum_ = 0.0;
    const Vector3 centre = positions_.row(vertex);
    for (Index k = 0; k < valence; ++k) {
        const Vector3 edge = Vector3(positions_.row(ring[k])) - centre;
        projected_.height[k] = projected_.normal.dot(edge);
        projected_.tangential[k] = edge - projected_.height[k] * projected_.normal;
        projected_.radius[k] = projected_.tangential[k].norm();
        projected_.largest_radius = std::max(projected_.largest_radius, projected_.radius[k]);
        radius_sum_ += projected_.radius[k];
    }
    projected_.mean_radius = radius_sum_ / valence;
}

/// How far the weights miss v'_i.
double RingEncoder::tangential_error() const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < weights_.size(); ++k)
        sum += weights_[k] * projected_.tangential[k];
    return sum.norm();
}

/// The height over an edge is |T| b by equation 11; a huge b, or weights that already amplify, call for u_ij.
bool RingEncoder::needs_own_normal_weights(std::uint8_t flags) const {
    if ((flags & (kLargeWeights | kOnRingVertex)) != 0) return true;
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        if (std::abs(projected_.height[k]) > kSteepestCotangent * projected_.radius[k]) return true;
    }
    return false;
}

void RingEncoder::fill_heights(std::uint8_t flags) {
    const double least_radius = kRounding * projected_.largest_radius;
    double centre_height = 0.0;  // of p over v_i
    for (std::size_t k = 0; k < weights_.size(); ++k)
        centre_height += weights_[k] * projected_.height[k];
    cotangents_.resize(weights_.size());
    heights_.resize(weights_.size());
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        const double radius = projected_.radius[k];
        // (v_i - v_j) . n over |v'_i - v'_j|: equation 9 without the cancellation of 1 - c^2.
        // Capped where the edge is parallel to the normal; such a ring is steep and does not use it.
        cotangents_[k] = -projected_.height[k] / std::max(radius, least_radius);
        // The predictor sees |v'_i - v'_j| across its soft normal, and multiplies by that: undo both.
        const double along = (1.0 - kRestNormalLength * kRestNormalLength) * (centre_height - projected_.height[k]);
        const double seen_radius = std::max(std::sqrt(radius * radius + along * along), least_radius);
        const double weight = (flags & kSteepEdge) != 0 ? radius / radius_sum_ : weights_[k];
        heights_[k] = -projected_.height[k] * weight / (seen_radius * kRestNormalLength);
    }
}

bool spans_a_plane(const PositionsView& positions, const Index* ring, Index valence) {
    if (valence < 3) return false;
    double perimeter = 0.0;
    for (Index k = 0; k < valence; ++k) {
        perimeter += (positions.row(ring[k + 1 < valence ? k + 1 : 0]) - positions.row(ring[k])).norm();
    }
    const RingArea polygon = ring_area(positions, ring, valence);
    return polygon.area.norm() > kCoincident * perimeter * perimeter;
}

std::vector<Index> extended_ring(const PositionsView& positions, const OneRings& rings, Index vertex) {
    std::vector<Index> reached(rings.begin(vertex), rings.end(vertex));
    std::unordered_set<Index> known(reached.begin(), reached.end());
    known.insert(vertex);
    std::size_t border = 0;
    for (int width = 2; width <= kWidestExtension; ++width) {
        const std::size_t border_end = reached.size();
        for (; border < border_end; ++border) {
            const Index neighbour = reached[border];
            const std::ptrdiff_t count = rings.end(neighbour) - rings.begin(neighbour);
            const std::ptrdiff_t taken = std::min(count, kMostOfNeighbour);
            for (std::ptrdiff_t k = 0; k < taken; ++k) {
                const Index other = rings.begin(neighbour)[k * count / taken];
                if (known.insert(other).second) reached.push_back(other);
            }
        }
        if (reached.size() < 3) continue;
        std::vector<Index> ring = sorted_by_angle(positions, reached);
        if (spans_a_plane(positions, ring.data(), static_cast<Index>(ring.size()))) return ring;
    }
    return {};
}

}  // namespace meanvalue
