#include "meanvalue/deform/loose_parts.h"

#include <algorithm>
#include <cstddef>

#include "meanvalue/common/parallel.h"
#include "meanvalue/deform/loose_patches.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

template <typename Scalar>
double length_of_star(const LoosePatch& patch, std::size_t number, const Scalar* positions) {
    const std::vector<Index>& star = patch.stars[number];
    return star_length(patch.middles[number], star.data(), star.data() + star.size(), positions);
}

/// How much the surface grows: the median over the stars, which a few stretched ones do not move.
/// @param length of the star of that number, where the surface is now.
template <typename Length>
double growth_of(const LoosePatch& patch, const Length& length) {
    std::vector<double> ratios;
    ratios.reserve(patch.stars.size());
    for (std::size_t k = 0; k < patch.stars.size(); ++k)
        ratios.push_back(length(k) / patch.star_lengths[k]);
    if (ratios.empty()) return 1.0;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
}

/// The turn comes from what is around as well, since few points hardly tell it; the place from what is touched alone,
/// since what is around may have moved less or more.
template <typename Scalar, typename Length>
Similarity motion_of(const LoosePatch& patch, const PositionsView& rest, const Scalar* positions,
                     const Length& length) {
    const WeightedPoints& around = patch.around;
    const Vector3 to_centre = weighted_centre(around, positions);
    Matrix3 covariance = Matrix3::Zero();
    for (std::size_t k = 0; k < around.points.size(); ++k) {
        const Vector3 from = Vector3(rest.row(around.points[k])) - around.centre;
        const Vector3 to = place_of(positions, around.points[k]) - to_centre;
        covariance += around.weights[k] * to * from.transpose();
    }
    Similarity motion;
    motion.scale = growth_of(patch, length);
    motion.rotation = fit_rotation(covariance);
    motion.translation =
        weighted_centre(patch.contact, positions) - motion.scale * motion.rotation * patch.contact.centre;
    return motion;
}

}  // namespace

void let_go(Components& components, const std::vector<char>& is_resting) {
    for (std::size_t part = 0; part < components.parts.size(); ++part) {
        std::vector<Index>& held = components.fixed[part];
        if (!std::all_of(held.begin(), held.end(), [&](Index v) { return is_resting[v] != 0; })) continue;
        held.clear();
        components.parts[part].soft_count = 0;
        components.parts[part].undetermined = 7;
    }
}

LooseParts::LooseParts(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                       const Execution& execution) {
    const auto is_loose = [&](std::size_t part) { return components.fixed[part].empty(); };
    std::size_t loose = 0;
    for (std::size_t part = 0; part < components.parts.size(); ++part)
        loose += is_loose(part) ? 1 : 0;
    if (loose == 0 || loose == components.parts.size()) return;
    FoundPatches found = find_patches(rest, faces, components, execution);
    carriers_ = std::move(found.carriers);
    patches_ = std::move(found.patches);
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        const Index patch = found.patch_of_part[components.part_of[v]];
        if (patch < 0) continue;
        vertices_.push_back(static_cast<Index>(v));
        patch_of_.push_back(patch);
    }
}

template <typename Scalar>
void LooseParts::carry(const PositionsView& rest, Scalar* positions, int threads, const Execution& execution) const {
    std::vector<Similarity> motions(patches_.size());
    const Scalar* const now = positions;
    parallel_for(static_cast<Index>(patches_.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const LoosePatch& patch = patches_[k];
            motions[k] =
                motion_of(patch, rest, now, [&](std::size_t star) { return length_of_star(patch, star, now); });
        }
    });
    parallel_for(static_cast<Index>(vertices_.size()), threads, execution,
                 [&](Index begin, Index end) { move(begin, end, rest, motions, positions); });
}

void LooseParts::carry(const PositionsView& rest, double* positions, StarLengths& known,
                       const Execution& execution) const {
    const double* const now = positions;
    std::vector<Similarity> motions(patches_.size());
    for (std::size_t k = 0; k < patches_.size(); ++k) {
        execution.check_every(k);
        const LoosePatch& patch = patches_[k];
        motions[k] = motion_of(patch, rest, now, [&](std::size_t star) {
            double& found = known[patch.middles[star]];
            if (found < 0.0) found = length_of_star(patch, star, now);
            return found;
        });
    }
    move(0, static_cast<Index>(vertices_.size()), rest, motions, positions);
}

template <typename Scalar>
void LooseParts::move(Index begin, Index end, const PositionsView& rest, const std::vector<Similarity>& motions,
                      Scalar* positions) const {
    for (Index k = begin; k < end; ++k) {
        const Vector3 place = motions[patch_of_[k]].apply(rest.row(vertices_[k]).transpose());
        Scalar* to = positions + 3 * static_cast<std::ptrdiff_t>(vertices_[k]);
        for (int c = 0; c < 3; ++c)
            to[c] = static_cast<Scalar>(place(c));
    }
}

template void LooseParts::carry(const PositionsView&, double*, int, const Execution&) const;
template void LooseParts::carry(const PositionsView&, float*, int, const Execution&) const;

std::size_t LooseParts::bytes() const {
    std::size_t total = (carriers_.size() + vertices_.size() + patch_of_.size()) * sizeof(Index);
    for (const LoosePatch& patch : patches_) {
        for (const WeightedPoints* some : {&patch.contact, &patch.around})
            total += some->points.size() * (sizeof(Index) + sizeof(double));
        total += sizeof(patch);
        for (const std::vector<Index>& star : patch.stars)
            total += sizeof(std::vector<Index>) + sizeof(Index) + sizeof(double) + star.size() * sizeof(Index);
    }
    return total;
}

}  // namespace meanvalue
