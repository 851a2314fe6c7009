#include "meanvalue/follow/loose_parts.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {
namespace {

// Shares of the carrier's size: buttons, eyes, teeth of a figure have diagonals of 0.008 to 0.04, shoes 0.11; what is
// held in a hand is 0.1 away, skirts 0.014.
constexpr double kSmallPart = 0.05;
constexpr double kFarPart = 0.08;
// Up to this share it may be a ball: beyond, it goes around its carrier.
constexpr double kLargestBall = 0.3;
// A ball is so near to its sphere, in radii, and has a diagonal of 3.46 of these; half of one has 3.1.
constexpr double kBallRoughness = 0.06;
constexpr double kBallDiagonal = 3.25;
constexpr Index kSample = 256;

/// By the sphere that fits best: the least sum of (|x - c|^2 - r^2)^2.
bool is_ball(const PositionsView& rest, double diagonal) {
    const Vector3 middle = mean_row(rest);
    Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
    Eigen::Vector4d sums = Eigen::Vector4d::Zero();
    const auto scaled = [&](Eigen::Index v) { return Vector3((rest.row(v).transpose() - middle) / diagonal); };
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        Eigen::Vector4d row;
        row << 2.0 * scaled(v), 1.0;
        products += row * row.transpose();
        sums += scaled(v).squaredNorm() * row;
    }
    const Eigen::Vector4d fit = products.ldlt().solve(sums);
    const Vector3 centre = fit.head<3>();
    const double radius = std::sqrt(fit[3] + centre.squaredNorm());
    double squares = 0.0;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        const double error = (scaled(v) - centre).norm() / radius - 1.0;
        squares += error * error;
    }
    return 1.0 > kBallDiagonal * radius &&
           squares <= kBallRoughness * kBallRoughness * static_cast<double>(rest.rows());
}

/// Whether a part may be cloth by its shape: it is neither small beside its carrier nor a ball, as the eyes of a
/// bust.
/// @param size of its carrier.
bool may_be_cloth(const PositionsView& rest, double size, const Execution& execution) {
    if (rest.rows() < 4) return false;
    const double diagonal = mean_diagonal(rest, 1, execution);
    return diagonal > kSmallPart * size && !(diagonal <= kLargestBall * size && is_ball(rest, diagonal));
}

/// Whether it lies near enough to its carrier to bend with that.
bool lies_on(const PositionsView& rest, const TriangleTree& carrier, double size) {
    std::vector<double> distances;
    const Eigen::Index count = std::min<Eigen::Index>(rest.rows(), kSample);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Vector3 point = rest.row(k * rest.rows() / count);
        distances.push_back((carrier.nearest({point}, std::numeric_limits<double>::infinity()).point - point).norm());
    }
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle <= kFarPart * size;
}

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
                       FollowKind kind, InstructionSet instructions, int threads, const Execution& execution) {
    const auto loose = std::count_if(components.fixed.begin(), components.fixed.end(),
                                     [](const std::vector<Index>& fixed) { return fixed.empty(); });
    if (loose == 0 || loose == static_cast<std::ptrdiff_t>(components.parts.size())) return;
    FoundPatches found = find_patches(rest, faces, components, execution);
    carriers_ = found.carriers;
    if (kind != FollowKind::kRigid)
        find_clothes(rest, faces, components, found.containers, kind, instructions, threads, execution);
    if (sheets_) {  // which carry others
        Components held = components;
        for (std::size_t part = 0; part < is_cloth_.size(); ++part) {
            if (is_cloth_[part]) held.fixed[part].push_back(components.parts[part].first_vertex);
        }
        found = find_patches(rest, faces, held, execution);
        for (std::size_t part = 0; part < is_cloth_.size(); ++part)
            carriers_[part] = is_cloth_[part] ? carriers_[part] : found.carriers[part];
    }
    patches_ = std::move(found.patches);
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        const Index patch = found.patch_of_part[components.part_of[v]];
        if (patch < 0) continue;
        vertices_.push_back(static_cast<Index>(v));
        patch_of_.push_back(patch);
    }
}

void LooseParts::find_clothes(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                              const std::vector<Index>& containers, FollowKind kind, InstructionSet instructions,
                              int threads, const Execution& execution) {
    const auto is_held = [&](Index v) { return !components.fixed[components.part_of[v]].empty(); };
    const std::size_t part_count = components.parts.size();
    const auto members = grouped<Index>(part_count, [&](const auto& visit) {
        for (std::size_t v = 0; v < components.part_of.size(); ++v)
            visit(components.part_of[v], static_cast<Index>(v));
    });
    const auto rest_of = [&](std::size_t part) -> Positions {
        return rest(std::vector<Index>(members.of(part).begin(), members.of(part).end()), Eigen::all);
    };
    std::vector<Index> carrier;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (is_held(faces(f, 0))) carrier.push_back(f);
    }
    if (carrier.empty()) return;
    std::vector<Index> held;
    for (Index v = 0; v < rest.rows(); ++v) {
        if (is_held(v)) held.push_back(v);
    }
    const double size = mean_diagonal(rest(held, Eigen::all), threads, execution);
    std::vector<char> is_cloth(part_count, 0);
    for (std::size_t part = 0; part < part_count; ++part) {
        if (!components.fixed[part].empty() || components.parts[part].vertex_count < 4) continue;
        is_cloth[part] = kind == FollowKind::kCloth || may_be_cloth(rest_of(part), size, execution) ? 1 : 0;
    }
    if (std::count(is_cloth.begin(), is_cloth.end(), 1) == 0) return;
    CarrierSurface surface(rest, faces(carrier, Eigen::all), size, threads, execution);
    const TriangleTree tree(rest, surface.faces(), components.part_of, execution);
    for (std::size_t part = 0; part < part_count && kind == FollowKind::kAuto; ++part) {
        if (is_cloth[part] && !lies_on(rest_of(part), tree, size)) is_cloth[part] = 0;
    }
    std::vector<Index> sheet_of(rest.rows(), -1);
    Index count = 0;
    is_cloth_ = is_cloth;
    for (std::size_t part = 0; part < part_count; ++part) {
        // What is within a rigid part goes with that: the iris of an eye.
        for (Index around = containers[part]; around >= 0 && kind == FollowKind::kAuto; around = containers[around]) {
            if (!is_cloth[around]) is_cloth_[part] = 0;
        }
        if (!is_cloth_[part]) continue;
        for (const Index v : members.of(part))
            sheet_of[v] = count;
        ++count;
    }
    if (count > 0)
        sheets_ = std::make_shared<const Sheets>(rest, std::move(surface), tree, faces, sheet_of, instructions,
                                                 threads, execution);
}

template <typename Scalar>
void LooseParts::carry(const PositionsView& rest, Scalar* positions, int threads, const Execution& execution) const {
    if (sheets_) {
        if constexpr (std::is_same_v<Scalar, double>) {
            sheets_->carry(positions, threads, execution);
        } else {
            std::vector<double> all(positions, positions + rest.size());
            sheets_->carry(all.data(), threads, execution);
            for (const Index v : sheets_->vertices())
                std::copy_n(all.data() + 3 * std::ptrdiff_t{v}, 3, positions + 3 * std::ptrdiff_t{v});
        }
    }
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
