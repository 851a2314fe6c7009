// Morpher::Bound: how shapes are put over each other, and a result onto them.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/closest_rotation.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/morph/bound_shapes.h"

namespace meanvalue {
namespace {

// What a part's own turn counts beside the fit: enough that the whole does not turn over where average positions
// cancel each other, as those of a straight limb and of one that is curled up do.
constexpr double kTurnShare = 0.25;
// What a vertex without a weight counts when a graft is placed.
constexpr double kLeastCount = 1e-3;

/// Moves vertices by the rotation and translation that fit best for some of them. @param turn_share what the own turn
/// counts beside the fit.
void move_onto(const Positions& onto, const std::vector<double>& counts, double turn_share,
               const std::vector<Index>& by, const std::vector<Index>& vertices, Positions& positions) {
    const Correlation sums = correlate(positions, onto, by.data(), by.size(), counts);
    const double share = turn_share * std::sqrt(sums.from_spread * sums.to_spread) + turn_share * sums.from_spread;
    const Matrix3 rotation = fit_rotation(sums.covariance + share * Matrix3::Identity());
    for (const Index v : vertices) {
        const Vector3 offset = Vector3(positions.row(v)) - sums.from_centre;
        positions.row(v) = (sums.to_centre + rotation * offset).transpose();
    }
}

}  // namespace

Morpher::Bound::Overlay Morpher::Bound::overlay(const ShapeWeights& weights,
                                                const std::optional<std::vector<Index>>& parts,
                                                const Execution& execution) const {
    const std::vector<char> is_part = flag_parts(weights, parts);
    if (weights.is_uniform()) return stack(weights.mean());
    const std::vector<double> whole = whole_of(weights, is_part, execution);
    Overlay result = stack(whole);
    result.frames.assign(shapes.size(), Quaternion::Identity());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (!is_part[k]) continue;
        result.places[k] = place_of_part(k, weights, whole, result, execution);
        result.sizes[k] = result.places[k].scale;
        result.frames[k] = result.turn.conjugate() * quaternion_of(result.places[k].rotation) * cells->whole(k);
    }
    for (Index v = 0; v < encodings->layout().vertex_count(); ++v) {
        execution.check_every(v);
        double share = 0.0;
        for (std::size_t k = 0; k < shapes.size(); ++k)
            share += is_part[k] ? 0.0 : weights.of(v)[k];
        result.counts[v] *= std::max(share, kLeastCount);
    }
    return result;
}

/// About their centres, at their common size.
Morpher::Bound::Overlay Morpher::Bound::stack(const std::vector<double>& weights) const {
    Overlay result;
    result.sizes = cells->common_sizes(weights);
    result.turn = cells->whole_turn(weights);
    Vector3 middle = Vector3::Zero();
    for (std::size_t k = 0; k < shapes.size(); ++k)
        middle += weights[k] * Vector3(shapes[k].colwise().mean());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        Similarity place;
        place.scale = result.sizes[k];
        place.translation = middle - place.scale * Vector3(shapes[k].colwise().mean());
        result.places.push_back(place);
    }
    result.counts = stays;
    return result;
}

std::vector<char> Morpher::Bound::flag_parts(const ShapeWeights& weights,
                                             const std::optional<std::vector<Index>>& parts) const {
    const auto count = static_cast<Index>(shapes.size());
    std::vector<char> is_part(shapes.size(), parts ? 0 : 1);
    if (!parts) {
        const auto most = std::max_element(weights.mean().begin(), weights.mean().end()) - weights.mean().begin();
        is_part[most] = 0;
        return is_part;
    }
    for (const Index part : *parts) {
        if (part < 0 || part >= count)
            throw InvalidInput(message("parts has ", part, ", but there are ", count, " shapes"));
        is_part[part] = 1;
    }
    if (std::all_of(is_part.begin(), is_part.end(), [](char c) { return c != 0; }))
        throw InvalidInput(message("all ", count, " shapes are parts; leave out one that they are parts of"));
    return is_part;
}

/// The weights where the least of the parts enters: those of what they enter into.
std::vector<double> Morpher::Bound::whole_of(const ShapeWeights& weights, const std::vector<char>& is_part,
                                             const Execution& execution) const {
    Index at = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Index v = 0; v < encodings->layout().vertex_count() && least > 0.0; ++v) {
        execution.check_every(v);
        double sum = 0.0;
        for (std::size_t k = 0; k < shapes.size(); ++k)
            sum += is_part[k] ? std::abs(weights.of(v)[k]) : 0.0;
        if (sum < least) {
            least = sum;
            at = v;
        }
    }
    // What parts take of it goes to the first shape that is none: the whole is the mix without the parts, also where
    // these are everywhere. (Divided by what is left, it would be far beyond its shapes.)
    std::vector<double> whole(shapes.size(), 0.0);
    double others = 0.0;
    const auto base = static_cast<std::size_t>(std::find(is_part.begin(), is_part.end(), 0) - is_part.begin());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (is_part[k] || k == base) continue;
        whole[k] = weights.of(at)[k];
        others += whole[k];
    }
    whole[base] = 1.0 - others;
    return whole;
}

/// By what fits best where it goes over into the whole: against each shape of that, turned and scaled as these are in
/// between.
Similarity Morpher::Bound::place_of_part(std::size_t part, const ShapeWeights& weights,
                                         const std::vector<double>& whole, const Overlay& overlay,
                                         const Execution& execution) const {
    const Encoding& layout = encodings->layout();
    // A vertex counts by how much the weight changes from it to its ring.
    std::vector<Index> border;
    std::vector<double> changes(layout.vertex_count(), 0.0);
    bool is_there = false;
    for (Index v = 0; v < layout.vertex_count(); ++v) {
        execution.check_every(v);
        is_there = is_there || weights.of(v)[part] != 0.0;
        for (Index place = layout.ring_offsets[v]; place < layout.ring_offsets[v + 1]; ++place)
            changes[v] += std::abs(weights.of(v)[part] - weights.of(layout.ring[place])[part]);
        if (changes[v] > 0.0) border.push_back(v);
    }
    if (!is_there) return overlay.places[part];
    if (border.size() < 3) {
        border = unknowns.free;
        if (border.size() < 3) {
            border.resize(layout.vertex_count());
            std::iota(border.begin(), border.end(), 0);
        }
        std::fill(changes.begin(), changes.end(), 1.0);
    }
    Vector3 centre = Vector3::Zero();
    double sum = 0.0;
    for (const Index v : border) {
        centre += changes[v] * Vector3(shapes[part].row(v));
        sum += changes[v];
    }
    centre /= sum;
    const std::vector<Quaternion> between = cells->turns(whole, border, execution);
    Vector3 to = Vector3::Zero();
    Matrix3 turns = Matrix3::Zero();
    std::vector<double> scales(shapes.size(), 1.0);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (whole[k] == 0.0) continue;
        const Similarity fit = fit_similarity(shapes[part], shapes[k], border, changes);
        turns += whole[k] * turn_from(k, between, border, changes, execution) * fit.rotation;
        scales[k] = fit.scale * overlay.sizes[k];
        to += whole[k] * overlay.places[k].apply(fit.apply(centre));
    }
    Similarity place;
    place.scale = TurnedCells::geometric_mean(scales, whole.data());
    place.rotation = closest_rotation(turns);
    place.translation = to - place.scale * place.rotation * centre;
    return place;
}

/// What cells are turned by in the mean, from how they are in a shape. @param turns one for each of `vertices`.
Matrix3 Morpher::Bound::turn_from(std::size_t shape, const std::vector<Quaternion>& turns,
                                  const std::vector<Index>& vertices, const std::vector<double>& counts,
                                  const Execution& execution) const {
    std::vector<double> alone(shapes.size(), 0.0);
    alone[shape] = 1.0;
    const std::vector<Quaternion> from = cells->turns(alone, vertices, execution);
    Matrix3 sum = Matrix3::Zero();
    for (std::size_t k = 0; k < vertices.size(); ++k)
        sum += counts[vertices[k]] * (turns[k] * from[k].conjugate()).toRotationMatrix();
    return closest_rotation(sum);
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
        if (following.follows(all.front())) continue;
        std::vector<Index> held;
        if (parts.is_anchored[part])
            std::copy_if(all.begin(), all.end(), std::back_inserter(held), [&](Index v) { return is_fixed[v]; });
        move_onto(onto, counts, kTurnShare, held.size() >= 3 ? held : all, all, positions);
    }
}

void Morpher::Bound::take_along(const ShapeWeights& weights, int threads, const Execution& execution,
                                Positions& positions) const {
    if (following.empty()) return;
    const Positions onto = following.carried(shapes, weights, positions, threads, execution);
    for (const std::vector<Index>& part : parts.members) {
        if (following.follows(part.front())) move_onto(onto, {}, 0.0, part, part, positions);
    }
}

}  // namespace meanvalue
