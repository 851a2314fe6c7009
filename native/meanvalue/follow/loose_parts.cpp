#include "meanvalue/follow/loose_parts.h"

#include <algorithm>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {
namespace {

/// The rotation is that of what is around as well, since few points hardly determine it; the translation that of what
/// is touched alone, since what is around may have moved less or more.
Similarity motion_of(const LoosePatch& patch, const PositionsView& rest, const double* positions) {
    Similarity motion;
    motion.scale = patch.edges.growth(positions);
    motion.rotation = fit_rotation(patch.around.covariance(positions));
    motion.translation =
        patch.contact.centre(positions) - motion.scale * motion.rotation * patch.contact.centre(rest.data());
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
                       FollowKind kind, InstructionSet instructions, int threads, const Execution& execution) {
    std::vector<char> is_held;
    is_held.reserve(components.fixed.size());
    for (const std::vector<Index>& fixed : components.fixed)
        is_held.push_back(fixed.empty() ? 0 : 1);
    const auto held = std::count(is_held.begin(), is_held.end(), 1);
    if (held == 0 || held == static_cast<std::ptrdiff_t>(is_held.size())) return;
    std::vector<Index> held_vertices;
    for (Index v = 0; v < rest.rows(); ++v) {
        if (is_held[components.part_of[v]]) held_vertices.push_back(v);
    }
    double size = mean_diagonal(rest(held_vertices, Eigen::all), threads, execution);
    if (size == 0.0) size = 1.0;
    const CarrierSurface carrier(rest, faces, components.part_of, is_held, execution);
    if (carrier.tree().triangles().rows() == 0) return;  // points alone are held
    found_ = find_patches(rest, faces, components, carrier, size, kind, execution);
    std::vector<Index> number(is_held.size(), -1), sheet_of;
    Index count = 0;
    for (std::size_t part = 0; part < number.size(); ++part) {
        if (found_.is_cloth[part]) number[part] = count++;
    }
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        sheet_of.push_back(number[components.part_of[v]]);
        const Index patch = found_.patch_of_part[components.part_of[v]];
        if (patch < 0) continue;
        vertices_.push_back(static_cast<Index>(v));
        patch_of_.push_back(patch);
    }
    if (count > 0) {
        sheets_ =
            std::make_shared<const Sheets>(rest, carrier, size, faces, sheet_of, instructions, threads, execution);
    }
}

void LooseParts::carry(const PositionsView& rest, double* positions, int threads, const Execution& execution) const {
    if (sheets_) sheets_->carry(positions, threads, execution);
    std::vector<Similarity> motions;
    motions.reserve(found_.patches.size());
    for (const LoosePatch& patch : found_.patches)
        motions.push_back(motion_of(patch, rest, positions));
    parallel_for(static_cast<Index>(vertices_.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            Eigen::Map<Vector3>(positions + 3 * std::ptrdiff_t{vertices_[k]}) =
                motions[patch_of_[k]].apply(rest.row(vertices_[k]).transpose());
        }
    });
}

void LooseParts::carry(const PositionsView& rest, float* positions, int threads, const Execution& execution) const {
    if (found_.carriers.empty()) return;
    std::vector<double> exact(positions, positions + rest.size());
    carry(rest, exact.data(), threads, execution);
    std::transform(exact.begin(), exact.end(), positions, [](double number) { return static_cast<float>(number); });
}

}  // namespace meanvalue
