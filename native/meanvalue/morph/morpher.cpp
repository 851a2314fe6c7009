#include "meanvalue/morph/morpher.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/follow/loose_parts.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/extent.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/morph/cell_assembly.h"
#include "meanvalue/morph/shape_overlay.h"

namespace meanvalue {
namespace {

// A vertex is still that moves less than this share of the size between shapes: the more, the more of the body places
// the result; the less, the less it rocks.
constexpr double kStill = 0.02;
// Weight of a part's own rotation beside the fit: enough that it does not turn over where average positions cancel
// each other, as those of a straight limb and of one that is curled up do.
constexpr double kOwnRotation = 0.25;
// Parts that are smaller than this share of the largest one may follow. At 1 rounding decides between equal parts.
constexpr double kSmall = 0.5;
// A part follows where being carried from shape to shape misses it by no more than this share of how far it goes.
constexpr double kMisses = 0.5;
// Memory for each vertex, measured.
constexpr std::size_t kBytes = 750;
constexpr std::size_t kBytesOfShape = 300;

void check_shapes(const MorphBinding& binding) {
    if (binding.shapes.size() < 2) {
        throw InvalidInput(message("shapes has ", binding.shapes.size(), " shapes; give two or more"));
    }
    for (std::size_t k = 0; k < binding.shapes.size(); ++k) {
        const std::string name = message("shapes[", k, "]");
        require_count(name.c_str(), binding.shapes[k]->rows(), "row", binding.shapes[0]->rows(),
                      "vertices of shapes[0]");
        require_finite(*binding.shapes[k], name.c_str());
        require_moderate_extent(*binding.shapes[k]);
    }
}

/// The cells of a closed shape that is turned inside out have the opposite orientation: nothing is between.
void refuse_mirrored(const MorphBinding& binding, const OneRings& rings) {
    if (std::any_of(rings.closed.begin(), rings.closed.end(), [](char closed) { return closed == 0; })) return;
    const double first = signed_volume(*binding.shapes[0], *binding.faces);
    for (std::size_t k = 1; k < binding.shapes.size(); ++k) {
        const double other = signed_volume(*binding.shapes[k], *binding.faces);
        if (first * other >= 0.0) continue;
        throw InvalidInput(message("shapes[", k, "] is mirrored, or inside out: its volume is ", other,
                                   ", that of shapes[0] is ", first,
                                   "; mirror it back along one axis, or flip its faces"));
    }
}

/// n weights, kLeastWeight to 1 + kLeastWeight: how still each vertex is between the shapes.
std::vector<double> stillness(const std::vector<PositionsView>& shapes, double size, const Execution& execution) {
    const double even = 1.0 / static_cast<double>(shapes.size());
    std::vector<double> result(shapes[0].rows());
    execution.check();
    for (std::size_t v = 0; v < result.size(); ++v) {
        Vector3 mean = Vector3::Zero();
        for (const PositionsView& shape : shapes)
            mean += even * shape.row(v).transpose();
        double squares = 0.0;
        for (const PositionsView& shape : shapes)
            squares += even * (Vector3(shape.row(v)) - mean).squaredNorm() / (kStill * kStill * size * size);
        result[v] = kLeastWeight + std::max(0.0, 1.0 - squares) * std::max(0.0, 1.0 - squares);
    }
    return result;
}

/// Moves vertices by the rotation and translation that fit best for the vertices `by`. @param weights n, or empty.
void move_onto(const Positions& onto, const std::vector<double>& weights, double own_rotation,
               const std::vector<Index>& by, const std::vector<Index>& vertices, Positions& positions) {
    const Correlation sums = correlate(positions, onto, by.data(), by.size(), weights);
    const double share = own_rotation * (std::sqrt(sums.from_spread * sums.to_spread) + sums.from_spread);
    const Matrix3 rotation = fit_rotation(sums.covariance + share * Matrix3::Identity());
    for (const Index v : vertices) {
        const Vector3 offset = Vector3(positions.row(v)) - sums.from_centre;
        positions.row(v) = (sums.to_centre + rotation * offset).transpose();
    }
}

}  // namespace

/// Everything that does not depend on the weights.
struct Morpher::Bound {
    std::vector<SharedPositions> kept;
    std::vector<PositionsView> shapes;           // of these
    std::vector<std::vector<Index>> parts;       // of the mesh: their vertices
    std::vector<std::vector<Index>> anchors_of;  // each part
    std::vector<double> still;                   // n: stillness()
    int threads = 1;
    OneRings rings;  // of all shapes
    std::unique_ptr<const LocalCells> cells;
    std::vector<char> follows;           // of each part: whether it goes along with another from shape to shape
    std::vector<LooseParts> carried_by;  // in each shape; none where no part follows
    std::unique_ptr<const CellAssembly> assembly;

    /// Moves each part onto `onto` by a rotation and a translation. @param weights n.
    void place(const Positions& onto, const std::vector<double>& weights, Positions& positions) const {
        for (std::size_t part = 0; part < parts.size(); ++part) {
            if (follows[part]) continue;
            const bool by_anchors = anchors_of[part].size() >= 3;
            move_onto(onto, weights, kOwnRotation, by_anchors ? anchors_of[part] : parts[part], parts[part],
                      positions);
        }
    }

    void find_following(const TrianglesView& faces, Components components, const Execution& execution);
    void carry_following(const ShapeWeights& weights, int threads, const Execution& execution,
                         Positions& positions) const;
};

/// Small parts (eyes, teeth, buttons) follow that are not anchored, if they go from each shape to the next, round
/// about, as the surface near to them carries them (LooseParts).
/// @param components with the anchors of each part.
void Morpher::Bound::find_following(const TrianglesView& faces, Components components, const Execution& execution) {
    follows.assign(parts.size(), 1);
    for (const PositionsView& shape : shapes) {
        execution.check();
        std::vector<double> sizes;
        sizes.reserve(parts.size());
        for (const std::vector<Index>& part : parts)
            sizes.push_back(bounding_box_diagonal(shape(part, Eigen::all)));
        const double largest = *std::max_element(sizes.begin(), sizes.end());
        for (std::size_t part = 0; part < parts.size(); ++part)
            follows[part] &= sizes[part] < kSmall * largest ? 1 : 0;
    }
    for (std::size_t part = 0; part < parts.size(); ++part) {
        if (!components.is_loose(static_cast<Index>(part))) follows[part] = 0;
        if (!follows[part]) components.fixed[part].push_back(parts[part].front());
    }
    if (std::count(follows.begin(), follows.end(), 1) == 0) return;
    carried_by.resize(shapes.size());
    parallel_items(shapes.size(), threads, execution, [&](int, std::size_t k) {
        carried_by[k] =
            LooseParts(shapes[k], faces, components, FollowKind::kRigid, InstructionSet::kPortable, 1, execution);
    });
    std::vector<double> missed(parts.size(), 0.0);  // squared distances from where a part is carried
    std::vector<double> gone(parts.size(), 0.0);    // and from where it was
    for (std::size_t from = 0; from < shapes.size(); ++from) {
        const PositionsView& to = shapes[(from + 1) % shapes.size()];
        Positions carried = to;
        carried_by[from].carry(shapes[from], carried.data(), threads, execution);
        const Eigen::RowVector3d shift = (mean_row(to) - mean_row(shapes[from])).transpose();
        for (std::size_t part = 0; part < parts.size(); ++part) {
            for (const Index v : parts[part]) {
                missed[part] += (carried.row(v) - to.row(v)).squaredNorm();
                gone[part] += (shapes[from].row(v) + shift - to.row(v)).squaredNorm();
            }
        }
    }
    for (std::size_t part = 0; part < parts.size(); ++part)
        follows[part] &= missed[part] <= kMisses * kMisses * gone[part] ? 1 : 0;
    if (std::count(follows.begin(), follows.end(), 1) == 0) carried_by.clear();
}

/// Placed each by itself, a part is at the average of its own positions: an eye of a head that rotates would go
/// straight while the head goes round. So each shape carries parts that follow along with the surface that is near to
/// them there, and they are placed by the average of that. At each shape alone they are where that shape has them.
void Morpher::Bound::carry_following(const ShapeWeights& weights, int threads, const Execution& execution,
                                     Positions& positions) const {
    Positions onto = Positions::Zero(positions.rows(), 3), carried = positions;
    for (std::size_t k = 0; k < carried_by.size(); ++k) {
        if (weights.is_uniform() && weights.mean()[k] == 0.0) continue;
        carried_by[k].carry(shapes[k], carried.data(), threads, execution);
        for (Index v = 0; v < onto.rows(); ++v)
            onto.row(v) += weights.of(v)[k] * carried.row(v);
    }
    for (std::size_t part = 0; part < parts.size(); ++part)
        if (follows[part]) move_onto(onto, {}, 0.0, parts[part], parts[part], positions);
}

Morpher::Morpher(const MorphBinding& binding, Execution& execution) {
    pin_eigen_cache_sizes();
    check_shapes(binding);
    auto bound = std::make_unique<Bound>();
    const auto vertices = static_cast<Index>(binding.shapes[0]->rows());
    const auto count = static_cast<Index>(binding.shapes.size());
    bound->threads = thread_count(binding.threads);
    std::vector<double> sizes;
    bound->kept = binding.shapes;
    for (const SharedPositions& shape : bound->kept) {
        execution.check();
        bound->shapes.emplace_back(*shape);
        sizes.push_back(mean_diagonal(*shape, bound->threads, execution));
        if (!(sizes.back() > 0.0))
            throw InvalidInput(
                message("all vertices of shapes[", sizes.size() - 1, "] are in one place; give a shape"));
    }
    const std::vector<char> is_anchor = fixed_flags(vertices, binding.anchors, {});
    const std::vector<double> even(count, 1.0 / count);
    {
        const StageTimer timer(report_.timings, "cells");
        execution.begin_stage("cells");
        bound->rings = collect_one_rings(vertices, *binding.faces, execution);
        refuse_mirrored(binding, bound->rings);
        const Components components = find_components(*binding.shapes[0], *binding.faces, is_anchor, execution);
        bound->anchors_of = components.fixed;
        bound->parts.resize(components.parts.size());
        for (Index v = 0; v < vertices; ++v)
            bound->parts[components.part_of[v]].push_back(v);
        bound->cells = std::make_unique<LocalCells>(bound->rings, bound->shapes, bound->threads, execution);
        bound->find_following(*binding.faces, components, execution);
        bound->still = stillness(bound->shapes, geometric_mean(sizes, even), execution);
    }
    const StageTimer timer(report_.timings, "factor");
    execution.begin_stage("factor");
    std::vector<Quaternion> rotations;
    std::vector<Vector3> edges;
    bound->cells->fill(ShapeWeights(even, count, vertices), bound->cells->common_sizes(even), {},
                       Quaternion::Identity(), bound->threads, execution, rotations, edges);
    bound->assembly =
        std::make_unique<CellAssembly>(bound->rings, edges, binding.instructions, bound->threads, execution);
    report_.shape_count = count;
    report_.vertex_count = vertices;
    report_.component_count = static_cast<Index>(bound->parts.size());
    report_.bytes = (kBytes + kBytesOfShape * count) * vertices;
    bound_ = std::move(bound);
}

Solution Morpher::solve(const std::vector<double>& weights, const MorphOptions& options,
                        const Execution& execution) const {
    const ShapeWeights normalised(weights, report_.shape_count, report_.vertex_count);
    const int threads = options.threads == 0 ? bound_->threads : thread_count(options.threads);
    Solution solution;
    {
        const StageTimer timer(solution.timings, "total");
        const ShapeOverlay overlay =
            overlay_shapes(bound_->shapes, bound_->rings, *bound_->cells, normalised, options.parts, execution);
        std::vector<double> place_weights = bound_->still;
        for (std::size_t v = 0; v < overlay.whole_shares.size(); ++v)
            place_weights[v] *= overlay.whole_shares[v];
        std::vector<Quaternion> rotations;
        std::vector<Vector3> edges;
        bound_->cells->fill(normalised, overlay.sizes, overlay.frames, overlay.rotation, threads, execution,
                            rotations, edges);
        const Positions linear = linear_blend(bound_->shapes, normalised, overlay, threads, execution);
        solution.vertices = linear;
        bound_->assembly->solve(edges, rotations, threads, execution, solution.vertices);
        bound_->place(linear, place_weights, solution.vertices);
        if (!bound_->carried_by.empty()) bound_->carry_following(normalised, threads, execution, solution.vertices);
    }
    require_finite_result(solution.vertices, "weights");
    solution.energies = {0.0};
    solution.converged = true;
    solution.stop_reason = "converged";
    return solution;
}

}  // namespace meanvalue
