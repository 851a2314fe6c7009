// Morpher::Bound: how shapes are put over each other, and a result onto them.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/morph/bound_shapes.h"

namespace meanvalue {
namespace {

// What a part's own turn counts beside the fit: enough that the whole does not turn over where average positions
// cancel each other, as those of a straight limb and of one that is curled up do.
constexpr double kTurnShare = 0.25;
// What a vertex without a weight counts when a graft is placed.
constexpr double kLeastCount = 1e-3;

}  // namespace

Morpher::Bound::Overlay Morpher::Bound::overlay(const ShapeWeights& weights, const Execution& execution) const {
    if (!weights.is_uniform()) return graft(weights, execution);
    Overlay result;
    result.sizes = cells->common_sizes(weights.mean());
    result.turn = cells->whole_turn(weights.mean());
    Vector3 middle = Vector3::Zero();
    for (std::size_t k = 0; k < shapes.size(); ++k)
        middle += weights.mean()[k] * Vector3(shapes[k].colwise().mean());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        Similarity place;
        place.scale = result.sizes[k];
        place.translation = middle - place.scale * Vector3(shapes[k].colwise().mean());
        result.places.push_back(place);
    }
    result.counts = stays;
    return result;
}

Morpher::Bound::Overlay Morpher::Bound::graft(const ShapeWeights& weights, const Execution& execution) const {
    const Encoding& layout = encodings->layout();
    const auto most = static_cast<std::size_t>(std::max_element(weights.mean().begin(), weights.mean().end()) -
                                               weights.mean().begin());
    Overlay result;
    result.turn = cells->whole(most);
    std::vector<Index> all_vertices(layout.vertex_count());
    std::iota(all_vertices.begin(), all_vertices.end(), 0);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        // The border of shape k counts by how much its weight changes from a vertex to its ring.
        std::vector<Index> border;
        std::vector<double> changes(layout.vertex_count(), 0.0);
        for (Index v = 0; v < layout.vertex_count(); ++v) {
            execution.check_every(v);
            for (Index place = layout.ring_offsets[v]; place < layout.ring_offsets[v + 1]; ++place)
                changes[v] += std::abs(weights.of(v)[k] - weights.of(layout.ring[place])[k]);
            if (changes[v] > 0.0) border.push_back(v);
        }
        Similarity place;
        if (k != most) {
            if (border.size() < 3) {
                border = unknowns.free.size() < 3 ? all_vertices : unknowns.free;
                changes.clear();
            }
            place = fit_similarity(shapes[k], shapes[most], border, changes);
        }
        result.places.push_back(place);
        result.sizes.push_back(place.scale);
        result.frames.push_back(result.turn.conjugate() * quaternion_of(place.rotation) * cells->whole(k));
    }
    for (Index v = 0; v < layout.vertex_count(); ++v)
        result.counts.push_back(std::max(weights.of(v)[most], kLeastCount));
    return result;
}

Positions Morpher::Bound::linear_blend(const ShapeWeights& weights, const Overlay& overlay, int threads,
                                       const Execution& execution) const {
    Positions blend(shapes[0].rows(), 3);
    parallel_for(static_cast<Index>(blend.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Vector3 sum = Vector3::Zero();
            for (std::size_t k = 0; k < shapes.size(); ++k)
                sum += weights.of(v)[k] * overlay.places[k].apply(shapes[k].row(v));
            blend.row(v) = sum.transpose();
        }
    });
    return blend;
}

void Morpher::Bound::place(const Positions& onto, const std::vector<double>& counts, bool skip_anchored,
                           Positions& positions) const {
    for (std::size_t part = 0; part < parts.members.size(); ++part) {
        if (skip_anchored && parts.is_anchored[part]) continue;
        const std::vector<Index>& all = parts.members[part];
        std::vector<Index> held;
        if (parts.is_anchored[part])
            std::copy_if(all.begin(), all.end(), std::back_inserter(held), [&](Index v) { return is_fixed[v]; });
        const std::vector<Index>& by = held.size() >= 3 ? held : all;
        const Correlation sums = correlate(positions, onto, by.data(), by.size(), counts);
        const double share =
            kTurnShare * std::sqrt(sums.from_spread * sums.to_spread) + kTurnShare * sums.from_spread;
        const Matrix3 rotation = fit_rotation(sums.covariance + share * Matrix3::Identity());
        for (const Index v : all) {
            const Vector3 offset = Vector3(positions.row(v)) - sums.from_centre;
            positions.row(v) = (sums.to_centre + rotation * offset).transpose();
        }
    }
}

}  // namespace meanvalue
