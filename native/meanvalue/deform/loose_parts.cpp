#include "meanvalue/deform/loose_parts.h"

#include <algorithm>
#include <cstddef>

#include "meanvalue/common/parallel.h"
#include "meanvalue/deform/loose_patches.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

/// How much the surface grows: the median over edges, which a few stretched ones do not move.
template <typename Scalar>
double growth_of(const LoosePatch& patch, const Scalar* positions) {
    if (patch.edges.empty()) return 1.0;
    std::vector<double> ratios;
    for (std::size_t k = 0; k < patch.edges.size(); ++k) {
        const auto [from, to] = patch.edges[k];
        ratios.push_back((point_at(positions, to) - point_at(positions, from)).norm() / patch.lengths[k]);
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
}

/// The rotation is that of what is around as well, since few points hardly determine it; the translation that of what
/// is touched alone, since what is around may have moved less or more.
template <typename Scalar>
Similarity motion_of(const LoosePatch& patch, const PositionsView& rest, const Scalar* positions) {
    const WeightedPoints& around = patch.around;
    const Vector3 to_centre = weighted_centre(around, positions);
    Matrix3 covariance = Matrix3::Zero();
    for (std::size_t k = 0; k < around.points.size(); ++k) {
        const Vector3 from = Vector3(rest.row(around.points[k])) - around.centre;
        const Vector3 to = point_at(positions, around.points[k]) - to_centre;
        covariance += around.weights[k] * to * from.transpose();
    }
    Similarity motion;
    motion.scale = growth_of(patch, positions);
    motion.rotation = fit_rotation(covariance);
    motion.translation =
        weighted_centre(patch.contact, positions) - motion.scale * motion.rotation * patch.contact.centre;
    return motion;
}

}  // namespace

void free_parts_held_by_border(Components& components, const std::vector<char>& is_border) {
    for (std::size_t part = 0; part < components.parts.size(); ++part) {
        std::vector<Index>& fixed = components.fixed[part];
        if (!std::all_of(fixed.begin(), fixed.end(), [&](Index v) { return is_border[v] != 0; })) continue;
        fixed.clear();
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
    parallel_for(static_cast<Index>(patches_.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k)
            motions[k] = motion_of(patches_[k], rest, static_cast<const Scalar*>(positions));
    });
    parallel_for(static_cast<Index>(vertices_.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Vector3 point = motions[patch_of_[k]].apply(rest.row(vertices_[k]).transpose());
            Scalar* const to = positions + 3 * static_cast<std::ptrdiff_t>(vertices_[k]);
            for (int c = 0; c < 3; ++c)
                to[c] = static_cast<Scalar>(point(c));
        }
    });
}

template void LooseParts::carry(const PositionsView&, double*, int, const Execution&) const;
template void LooseParts::carry(const PositionsView&, float*, int, const Execution&) const;

}  // namespace meanvalue
