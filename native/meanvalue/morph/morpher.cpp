#include "meanvalue/morph/morpher.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/extent.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/morph/cell_assembly.h"
#include "meanvalue/morph/following_parts.h"
#include "meanvalue/morph/shape_overlay.h"

namespace meanvalue {
namespace {

// A vertex is still that moves less than this share of the size between shapes: the more, the more of the body places
// the result; the less, the less it rocks.
constexpr double kStill = 0.02;
// Weight of a part's own rotation beside the fit: enough that it does not turn over where average positions cancel
// each other, as those of a straight limb and of one that is curled up do.
constexpr double kOwnRotation = 0.25;
// Memory for each vertex, measured.
constexpr std::size_t kBytes = 750;
constexpr std::size_t kBytesOfShape = 300;

void check_shapes(const MorphBinding& binding) {
    if (binding.shapes.size() < 2) {
        throw InvalidInput(message("shapes has ", binding.shapes.size(), " shapes; give two or more"));
    }
    for (std::size_t k = 0; k < binding.shapes.size(); ++k) {
        const std::string name = message("shapes[", k, "]");
        if (binding.shapes[k]->rows() != binding.shapes[0]->rows()) {
            throw InvalidInput(message(name, " has ", binding.shapes[k]->rows(), " vertices, but shapes[0] has ",
                                       binding.shapes[0]->rows(), "; all must be of one mesh"));
        }
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
    FollowingParts following;
    std::unique_ptr<const CellAssembly> assembly;

    /// Moves each part onto `onto` by a rotation and a translation. @param weights n.
    void place(const Positions& onto, const std::vector<double>& weights, Positions& positions) const {
        for (std::size_t part = 0; part < parts.size(); ++part) {
            if (following.follows(parts[part].front())) continue;
            const bool by_anchors = anchors_of[part].size() >= 3;
            move_onto(onto, weights, kOwnRotation, by_anchors ? anchors_of[part] : parts[part], parts[part],
                      positions);
        }
    }

    /// Moves parts that follow to where the others carry them.
    void carry_following(const ShapeWeights& weights, int threads, const Execution& execution,
                         Positions& positions) const {
        if (following.empty()) return;
        const Positions onto = following.carried(shapes, weights, positions, threads, execution);
        for (const std::vector<Index>& part : parts) {
            if (following.follows(part.front())) move_onto(onto, {}, 0.0, part, part, positions);
        }
    }
};

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
        bound->following = FollowingParts(bound->shapes, *binding.faces, components, bound->threads, execution);
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

Morpher::~Morpher() = default;

Solution Morpher::solve(const std::vector<double>& weights, const MorphOptions& options,
                        const Execution& execution) const {
    const ShapeWeights normalised(weights, report_.shape_count, report_.vertex_count);
    const int threads = options.threads == 0 ? bound_->threads : thread_count(options.threads);
    Solution solution;
    {
        const StageTimer timer(solution.timings, "total");
        const ShapeOverlay overlay = overlay_shapes(bound_->shapes, bound_->rings, *bound_->cells, normalised,
                                                    options.parts, threads, execution);
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
        bound_->carry_following(normalised, threads, execution, solution.vertices);
    }
    require_finite_result(solution.vertices, "weights");
    solution.energies = {0.0};
    solution.converged = true;
    solution.stop_reason = "converged";
    return solution;
}

}  // namespace meanvalue
