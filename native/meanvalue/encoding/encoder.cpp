#include "meanvalue/encoding/encoder.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/mean_value_weights.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/encoding/projection_plane.h"
#include "meanvalue/encoding/ring_extension.h"

namespace meanvalue {
namespace {

// An edge less than about 3 degrees off the normal: its b is unbounded, so the u_ij form takes over.
constexpr double kSteepestCotangent = 20.0;
// The predictor must give the rest position back to this share of the ring's radius with mean-value weights,
// or least-norm weights are tried; nothing above kLargestError is accepted.
constexpr double kRoundingError = 1e-12;
constexpr double kLargestError = 1e-9;

/// Encodes one vertex after another into a shared Encoding whose rings are already laid out.
/// One instance for each thread: it keeps scratch memory.
class VertexEncoder {
  public:
    /// @param normals n x 3 of unit length or zero, or nullptr for those of the rings.
    VertexEncoder(const PositionsView& positions, const PositionsView* normals, Encoding& encoding)
        : positions_(positions), normals_(normals), encoding_(encoding) {}

    /// Fills weights, cotangents and heights of `vertex`; returns its GuardReason flags.
    std::uint8_t encode(Index vertex) {
        if (!encoding_.predictable(vertex)) return kNotPredictable;
        project(vertex);
        if (projected_.normal.isZero(0.0)) return kNotPredictable;
        std::uint8_t flags = 0;
        switch (mean_value_weights(projected_, weights_)) {
            case WeightRule::kMeanValue:
                break;
            case WeightRule::kOnRingEdge:
                flags |= kOnRingEdge;
                break;
            case WeightRule::kOnRingVertex:
                flags |= kOnRingVertex;
                break;
        }
        if (!weights_are_tame(weights_) || tangential_error() > kRoundingError * projected_.largest_radius) {
            least_norm_weights(projected_, weights_);
            flags = kLargeWeights;
            if (!(tangential_error() < kLargestError * projected_.largest_radius)) return kNotPredictable;
        }
        if (flags_need_own_normal_weights(flags)) flags |= kSteepEdge;
        store(vertex, flags);
        return flags;
    }

    /// u_ij of a vertex flagged kSteepEdge, appended to Encoding::steep_weights.
    void append_steep_weights(Index vertex) {
        project(vertex);
        encoding_.steep_offset[vertex] = static_cast<Index>(encoding_.steep_weights.size());
        for (const double radius : projected_.radius) {
            encoding_.steep_weights.push_back(radius / radius_sum());
        }
    }

  private:
    void project(Index vertex) {
        const Index begin = encoding_.ring_offsets[vertex];
        const Index valence = encoding_.ring_offsets[vertex + 1] - begin;
        const Index* ring = encoding_.ring.data() + begin;
        const RingArea polygon = ring_area(positions_, ring, valence);
        projected_.normal = normals_ != nullptr ? Vector3(normals_->row(vertex)) : polygon.area.normalized();
        encoding_.softening[vertex] = kSoftness * polygon.area.norm() / polygon.spread;
        projected_.tangential.resize(valence);
        projected_.radius.resize(valence);
        projected_.height.resize(valence);
        projected_.largest_radius = 0.0;
        const Vector3 centre = positions_.row(vertex);
        for (Index k = 0; k < valence; ++k) {
            const Vector3 edge = Vector3(positions_.row(ring[k])) - centre;
            projected_.height[k] = projected_.normal.dot(edge);
            projected_.tangential[k] = edge - projected_.height[k] * projected_.normal;
            projected_.radius[k] = projected_.tangential[k].norm();
            projected_.largest_radius = std::max(projected_.largest_radius, projected_.radius[k]);
        }
        projected_.mean_radius = radius_sum() / valence;
    }

    double radius_sum() const {
        double sum = 0.0;
        for (const double radius : projected_.radius)
            sum += radius;
        return sum;
    }

    /// How far the weights miss v'_i.
    double tangential_error() const {
        Vector3 sum = Vector3::Zero();
        for (std::size_t k = 0; k < weights_.size(); ++k)
            sum += weights_[k] * projected_.tangential[k];
        return sum.norm();
    }

    /// The height over an edge is |T| b by equation 11; a huge b, or weights that already amplify, call for u_ij.
    bool flags_need_own_normal_weights(std::uint8_t flags) const {
        if ((flags & (kLargeWeights | kOnRingVertex)) != 0) return true;
        for (std::size_t k = 0; k < weights_.size(); ++k) {
            if (std::abs(projected_.height[k]) > kSteepestCotangent * projected_.radius[k]) return true;
        }
        return false;
    }

    void store(Index vertex, std::uint8_t flags) {
        const Index begin = encoding_.ring_offsets[vertex];
        const double sum = radius_sum();
        double centre_height = 0.0;  // of p over v_i
        for (std::size_t k = 0; k < weights_.size(); ++k)
            centre_height += weights_[k] * projected_.height[k];
        for (std::size_t k = 0; k < weights_.size(); ++k) {
            const double radius = projected_.radius[k];
            // (v_i - v_j) . n over |v'_i - v'_j|: equation 9 without the cancellation of 1 - c^2.
            // Capped where the edge is parallel to the normal; such a ring is steep and does not use it.
            const double least_radius = kRoundingError * projected_.largest_radius;
            encoding_.weights[begin + k] = weights_[k];
            encoding_.cotangents[begin + k] = -projected_.height[k] / std::max(radius, least_radius);
            // The predictor sees |v'_i - v'_j| across its soft normal, and multiplies by that: undo both.
            const double along =
                (1.0 - kRestNormalLength * kRestNormalLength) * (centre_height - projected_.height[k]);
            const double seen_radius = std::max(std::hypot(radius, along), least_radius);
            const double weight = (flags & kSteepEdge) != 0 ? radius / sum : weights_[k];
            encoding_.heights[begin + k] = -projected_.height[k] * weight / (seen_radius * kRestNormalLength);
        }
    }

    const PositionsView& positions_;
    const PositionsView* normals_;
    Encoding& encoding_;
    ProjectedRing projected_;
    std::vector<double> weights_;
};

using RingReplacements = std::unordered_map<Index, std::vector<Index>>;

/// Rings for the vertices whose own ring spans no plane; empty ones where no wider ring does either.
RingReplacements replace_degenerate_rings(const OneRings& rings, const PositionsView& positions, int threads,
                                          const Execution& execution) {
    std::vector<char> degenerate(rings.vertex_count(), 0);
    parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
        std::vector<Index> ring;
        for (Index v = begin; v < end; ++v) {
            ring.assign(rings.begin(v), rings.end(v));
            degenerate[v] = !spans_a_plane(positions, ring);
        }
    });
    RingReplacements replacements;
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        if (!degenerate[v]) continue;
        execution.check();
        replacements.emplace(v, extended_ring(positions, rings, v));
    }
    return replacements;
}

void lay_out_rings(const OneRings& rings, const RingReplacements& replacements, Encoding& encoding) {
    encoding.ring_offsets.reserve(rings.vertex_count() + 1);
    encoding.ring_offsets.push_back(0);
    encoding.ring.reserve(rings.vertices.size());
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        const auto replacement = replacements.find(v);
        if (replacement == replacements.end()) {
            encoding.ring.insert(encoding.ring.end(), rings.begin(v), rings.end(v));
        } else {
            encoding.ring.insert(encoding.ring.end(), replacement->second.begin(), replacement->second.end());
        }
        encoding.ring_offsets.push_back(static_cast<Index>(encoding.ring.size()));
    }
    encoding.weights.resize(encoding.ring.size());
    encoding.cotangents.resize(encoding.ring.size());
    encoding.heights.resize(encoding.ring.size());
    encoding.softening.assign(rings.vertex_count(), 0.0);
    encoding.steep_offset.assign(rings.vertex_count(), -1);
}

/// Takes the rings of unpredictable vertices out, so that predictable() tells and no coefficient is left unset.
void drop_rings(const std::vector<std::uint8_t>& flags, Encoding& encoding) {
    const auto compact = [&](auto& items) {
        std::size_t kept = 0;
        for (Index v = 0; v < encoding.vertex_count(); ++v) {
            if ((flags[v] & kNotPredictable) != 0) continue;
            for (Index k = encoding.ring_offsets[v]; k < encoding.ring_offsets[v + 1]; ++k) {
                items[kept++] = items[k];
            }
        }
        items.resize(kept);
    };
    compact(encoding.ring);
    compact(encoding.weights);
    compact(encoding.cotangents);
    compact(encoding.heights);
    std::vector<Index> offsets(1, 0);
    for (Index v = 0; v < encoding.vertex_count(); ++v) {
        const bool dropped = (flags[v] & kNotPredictable) != 0;
        offsets.push_back(offsets.back() + (dropped ? 0 : encoding.ring_offsets[v + 1] - encoding.ring_offsets[v]));
    }
    encoding.ring_offsets = std::move(offsets);
}

Encoding encode_rings(const OneRings& rings, const PositionsView& positions, const PositionsView* normals,
                      int threads, Execution& execution) {
    execution.begin_stage("encode");
    const Index vertex_count = rings.vertex_count();
    const RingReplacements replacements = replace_degenerate_rings(rings, positions, threads, execution);
    Encoding encoding;
    lay_out_rings(rings, replacements, encoding);

    std::vector<std::uint8_t> flags(vertex_count, 0);
    parallel_for(vertex_count, threads, execution, [&](Index begin, Index end) {
        VertexEncoder encoder(positions, normals, encoding);
        for (Index v = begin; v < end; ++v)
            flags[v] = encoder.encode(v);
    });

    VertexEncoder encoder(positions, normals, encoding);
    bool all_predictable = true;
    for (Index v = 0; v < vertex_count; ++v) {
        execution.check_every(v);
        if ((flags[v] & kSteepEdge) != 0) encoder.append_steep_weights(v);
        if (rings.kinds[v] == RingKind::kNonManifold) flags[v] |= kNonManifold;
        if (encoding.predictable(v) && replacements.count(v) > 0) flags[v] |= kExtendedRing;
        if (flags[v] == 0) continue;
        if ((flags[v] & kNotPredictable) != 0) all_predictable = false;
        encoding.guarded.push_back(v);
        encoding.guard_reasons.push_back(flags[v]);
    }
    if (!all_predictable) drop_rings(flags, encoding);
    execution.set_progress(1.0);
    return encoding;
}

}  // namespace

Encoding encode(const OneRings& rings, const PositionsView& positions, int threads, Execution& execution) {
    return encode_rings(rings, positions, nullptr, threads, execution);
}

Encoding encode_along(const OneRings& rings, const PositionsView& positions, const PositionsView& normals,
                      int threads, Execution& execution) {
    return encode_rings(rings, positions, &normals, threads, execution);
}

}  // namespace meanvalue
