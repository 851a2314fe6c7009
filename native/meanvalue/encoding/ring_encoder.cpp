#include "meanvalue/encoding/ring_encoder.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

// An edge less than about 3 degrees off the normal: its b is unbounded, so the u_ij form takes over.
constexpr double kSteepestCotangent = 20.0;

}  // namespace

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

}  // namespace meanvalue
