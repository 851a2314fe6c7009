// FastSolve from rest, coarse to fine.
#include <algorithm>
#include <cmath>

#include "meanvalue/common/tolerances.h"
#include "meanvalue/decode/fast/fast_solve.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

// Handles that rotate by more than this (120 degrees) are also moved along their path, unless the shape is perfect
// without. Smaller rotations are found as well from the stiff stage (docs/decisions/0011-constant-matrix.md).
constexpr double kFarRotation = 2.1;
constexpr double kRotationOfStep = kFarRotation / 8.0;
// Stages before the last and steps along a path only lead to the next: no more iterations, and no smaller tolerance.
constexpr int kStageIterations = 20;
constexpr double kStageTolerance = 5e-4;
// Rounds of fitting examples and solving on the coarsest level, where weights do not settle earlier.
constexpr int kMostRounds = 40;

}  // namespace

/// Places the free vertices from the rest shape, coarse to fine, so that the whole mesh remains to be minimized.
/// @param from_rest what start_from_rest() gave, none: it is to be asked.
void FastSolve::start_cold(Positions& from_rest, Positions& positions) {
    if (from_rest.rows() > 0) {
        positions.swap(from_rest);
    } else {
        const StageTimer timer(timings_, "start");
        start_from_rest(positions);
    }
    if (has_examples()) {
        const StageTimer timer(timings_, "examples");
        relax_with_examples(coarsest(), kMostRounds, positions);
    }
    const StageTimer timer(timings_, "split");
    for (int coarse = static_cast<int>(problem_.levels.size()) - 2; coarse >= 0; --coarse) {
        problem_.hierarchy->levels[coarse].splits.carry(problem_.rest, positions, threads_, execution_);
        if (has_examples()) blend_examples(level(coarse));
        if (coarse > 0) relax(level(coarse), positions);
    }
}

/// To a minimum at the rigidity asked for. @return the energy.
double FastSolve::relax(Level level, Positions& positions) {
    const LbfgsOptions options = lbfgs_options(options_.max_iterations);
    return minimise(level, level.bound.stages.size() - 1, options, positions).energies.back();
}

/// n weights of fixed vertices and soft anchors where a part is carried along with them; empty: all alike.
std::vector<double> FastSolve::carrying_weights() const {
    std::vector<double> carrying = problem_.carrying;
    if (options_.weights == nullptr) return carrying;
    for (std::size_t k = 0; k < problem_.soft.size(); ++k) {
        // Free for the time being, so that a part without any other stays where it is.
        double& of_anchor = carrying[problem_.soft[k].vertex];
        of_anchor = std::max((*options_.weights)[problem_.soft[k].anchor] * of_anchor, kNegligible);
    }
    return carrying;
}

/// From rest, carried along with the fixed vertices.
void FastSolve::start_from_rest(Positions& positions) {
    pull_free_anchors_to(problem_.rest);
    if (options_.previous != nullptr)
        positions(whole().bound.energy->soft_constraints().vertices(), Eigen::all) = soft_targets();
    const Positions carried = carry_along(problem_.rest, positions, problem_.is_anchor, carrying_weights());
    execution_.check();
    std::vector<char> is_freed(options_.weights != nullptr ? problem_.is_fixed.size() : 0, 0);
    for (std::size_t k = 0; k < problem_.soft.size(); ++k) {
        const Index v = problem_.soft[k].vertex;
        if (!is_free(k)) continue;
        positions.row(v) = carried.row(v);
        is_freed[v] = 1;
    }
    pull_free_anchors_to(carried);
    const HandlePaths::Path path = problem_.handles->path_to(positions, is_freed);
    execution_.check();
    for (std::size_t v = 0; v < problem_.is_fixed.size(); ++v) {
        if (!problem_.is_fixed[v]) positions.row(v) = carried.row(v);
    }
    const Level level = coarsest();
    const Positions soft = level.bound.energy->soft_constraints().rows_of(positions);
    respond(level, 0, drivers_of(level.bound, positions, soft) - drivers_of(level.bound, carried, soft), positions);
    const Positions start = positions;
    for (std::size_t stage = 0; stage + 1 < level.bound.stages.size(); ++stage)
        minimise(level, stage, lbfgs_options(kStageIterations, kStageTolerance), positions);
    double energy = relax(level, positions);
    const auto keep_if_lower = [&](Positions& other, double other_energy) {
        if (!(other_energy < energy)) return;
        energy = other_energy;
        std::swap(positions, other);
    };
    // Stiff stages lead away from shapes that are perfect but larger or smaller.
    if (energy_of(level, start) < energy) {
        Positions carried_on = start;
        const double carried_on_energy = relax(level, carried_on);
        keep_if_lower(carried_on, carried_on_energy);
    }
    if (path.largest_angle_rad() > kFarRotation && energy > std::pow(kRounding * problem_.size, 2)) {
        Positions along_path = problem_.rest;
        const double path_energy = minimise_along(path, along_path);
        keep_if_lower(along_path, path_energy);
    }
}

double FastSolve::minimise_along(const HandlePaths::Path& path, Positions& positions) {
    const Level level = coarsest();
    const int steps = static_cast<int>(std::ceil(path.largest_angle_rad() / kRotationOfStep));
    for (int step = 1; step < steps; ++step) {
        place_along(path, static_cast<double>(step) / steps, level, positions);
        minimise(level, level.bound.stages.size() - 1, lbfgs_options(kStageIterations, kStageTolerance), positions);
    }
    place_along(path, 1.0, level, positions);
    return relax(level, positions);
}

}  // namespace meanvalue
