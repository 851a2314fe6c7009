#include "meanvalue/morph/shape_overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {
namespace {

std::vector<char> flag_parts(const ShapeWeights& weights, const std::optional<std::vector<Index>>& parts) {
    const Index count = weights.shape_count();
    std::vector<char> is_part(count, parts ? 0 : 1);
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

/// The weights of the whole without its parts: those of the vertex where the parts have least. What parts take there
/// goes to the first shape that is none. (Divided by what is left, it would be far beyond its shapes.)
std::vector<double> whole_of(const ShapeWeights& weights, const std::vector<char>& is_part, Index vertices) {
    Index at = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Index v = 0; v < vertices && least > 0.0; ++v) {
        double sum = 0.0;
        for (std::size_t k = 0; k < is_part.size(); ++k)
            sum += is_part[k] ? std::abs(weights.of(v)[k]) : 0.0;
        if (sum < least) {
            least = sum;
            at = v;
        }
    }
    std::vector<double> whole(is_part.size(), 0.0);
    double others = 0.0;
    const auto base = static_cast<std::size_t>(std::find(is_part.begin(), is_part.end(), 0) - is_part.begin());
    for (std::size_t k = 0; k < is_part.size(); ++k) {
        if (is_part[k] || k == base) continue;
        whole[k] = weights.of(at)[k];
        others += whole[k];
    }
    whole[base] = 1.0 - others;
    return whole;
}

/// Where a part fits best to the whole it enters: the mean of where it fits best to each shape of that.
Similarity place_of_part(const std::vector<PositionsView>& shapes, const OneRings& rings, std::size_t part,
                         const ShapeWeights& weights, const std::vector<double>& whole, const ShapeOverlay& overlay) {
    // A vertex counts by how much the weight of the part changes from it to its ring.
    std::vector<Index> border;
    std::vector<double> changes(rings.vertex_count(), 0.0);
    bool is_there = false;
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        is_there = is_there || weights.of(v)[part] != 0.0;
        for (const Index* neighbour = rings.begin(v); neighbour != rings.end(v); ++neighbour)
            changes[v] += std::abs(weights.of(v)[part] - weights.of(*neighbour)[part]);
        if (changes[v] > 0.0) border.push_back(v);
    }
    if (!is_there) return overlay.places[part];
    if (border.size() < 3) {  // it is everywhere
        border.resize(rings.vertex_count());
        std::iota(border.begin(), border.end(), 0);
        std::fill(changes.begin(), changes.end(), 1.0);
    }
    Vector3 centre = Vector3::Zero();
    double sum = 0.0;
    for (const Index v : border) {
        centre += changes[v] * Vector3(shapes[part].row(v));
        sum += changes[v];
    }
    centre /= sum;
    Vector3 to = Vector3::Zero();
    std::vector<Quaternion> rotations;
    std::vector<double> scales, shares;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (whole[k] == 0.0) continue;
        const Similarity fit = fit_similarity(shapes[part], shapes[k], border, changes);
        rotations.emplace_back(fit.rotation);
        scales.push_back(fit.scale * overlay.sizes[k]);
        shares.push_back(whole[k]);
        to += whole[k] * overlay.places[k].apply(fit.apply(centre));
    }
    Similarity place;
    place.scale = geometric_mean(scales, shares);
    place.rotation = mean_of_rotations(rotations, shares).toRotationMatrix();
    place.translation = to - place.scale * place.rotation * centre;
    return place;
}

}  // namespace

ShapeOverlay overlay_shapes(const std::vector<PositionsView>& shapes, const OneRings& rings, const LocalCells& cells,
                            const ShapeWeights& weights, const std::optional<std::vector<Index>>& parts,
                            const Execution& execution) {
    const std::vector<char> is_part = flag_parts(weights, parts);
    const std::vector<double> whole =
        weights.is_uniform() ? weights.mean() : whole_of(weights, is_part, rings.vertex_count());
    ShapeOverlay result{{}, cells.common_sizes(whole), {}, cells.mean_rotation(whole), {}};
    Vector3 middle = Vector3::Zero();
    for (std::size_t k = 0; k < shapes.size(); ++k)
        middle += whole[k] * mean_row(shapes[k]);
    for (std::size_t k = 0; k < shapes.size(); ++k) {  // about their centers, at their common size
        const double scale = result.sizes[k];
        result.places.push_back({scale, Matrix3::Identity(), middle - scale * mean_row(shapes[k])});
    }
    if (weights.is_uniform()) return result;
    result.frames.assign(shapes.size(), Quaternion::Identity());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (!is_part[k]) continue;
        execution.check();
        result.places[k] = place_of_part(shapes, rings, k, weights, whole, result);
        result.sizes[k] = result.places[k].scale;
        result.frames[k] =
            result.rotation.conjugate() * Quaternion(result.places[k].rotation) * cells.shape_rotation(k);
    }
    result.whole_shares.assign(rings.vertex_count(), 0.0);
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        for (std::size_t k = 0; k < shapes.size(); ++k)
            result.whole_shares[v] += is_part[k] ? 0.0 : weights.of(v)[k];
        result.whole_shares[v] = std::max(result.whole_shares[v], kLeastWeight);
    }
    return result;
}

Positions linear_blend(const std::vector<PositionsView>& shapes, const ShapeWeights& weights,
                       const ShapeOverlay& overlay, int threads, const Execution& execution) {
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

}  // namespace meanvalue
