// FastSolve from an earlier answer, as while dragging.
#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/decode/fast/fast_solve.h"

namespace meanvalue {
namespace {

// With a start, handles that turn or move farther than this, the move as a share of the size, are followed in steps.
constexpr double kTurnOfResponse = 0.3;
constexpr double kMoveOfResponse = 0.05;
constexpr int kMostResponses = 24;
constexpr int kStepsOfResponse = 5;
constexpr double kFollowTolerance = 1e-3;
// A predicted start may be so many times as high as the last answer; else the other start is looked at too.
constexpr double kMostRise = 2.0;

}  // namespace

/// Moves the free vertices by what the constant matrix answers to the moves of the fixed ones: the least energy of
/// all displacements, as far as it is the same in every pose. Where an anchor moves alone, its surroundings are torn
/// instead, and minimising has to begin from a spike. @param previous where the fixed vertices were; in `positions`
/// they are where they go, and free ones where they were.
void FastSolve::respond(Level level, std::size_t stage, const Positions& previous, Positions& positions) {
    const FixedCoupling& coupling = level.bound.stages[stage].coupling;
    Positions moves(static_cast<Eigen::Index>(coupling.vertices.size()), 3);
    for (std::size_t k = 0; k < coupling.vertices.size(); ++k)
        moves.row(k) = positions.row(coupling.vertices[k]) - previous.row(coupling.vertices[k]);
    if (moves.isZero(0.0)) return;
    Positions answer = -(coupling.matrix * moves);
    preconditioner_of(level, stage).solve(answer, answer, threads_, execution_);
    const std::vector<Index>& free = level.bound.unknowns.free;
    for (std::size_t k = 0; k < free.size(); ++k)
        positions.row(free[k]) += answer.row(k);
}

/// Puts soft anchors to where the targets were that they were in balance with at `previous`: behind them by as much
/// as the rest of the energy pulls there. Not farther off than the present targets are, if it was no balance at all.
/// Springs that pull to rest have done so before: those of a region's soft border are thousands, and far too weak for
/// the balance of a shape that is known to the tolerance only.
void FastSolve::put_balanced_targets(const Positions& previous, Positions& positions) {
    if (problem_.soft.empty()) return;
    const FastLevel& level = *problem_.levels.front();
    const Positions targets = work_.levels.front().energy.soft_targets;
    const bool knows_former =
        goes_on_ && &previous == options_.previous && former_soft_targets_.rows() == targets.rows();
    work_.levels.front().energy.soft_targets = level.energy->soft_constraints().rows_of(previous);
    Positions gradient(static_cast<Eigen::Index>(level.unknowns.free.size()), 3);
    level.energy->evaluate(previous, problem_.rigidity, gradient, threads_, execution_, work_.levels.front().energy);
    work_.levels.front().energy.soft_targets = targets;
    for (std::size_t k = 0; k < problem_.soft.size(); ++k) {
        const SoftAnchor& anchor = problem_.soft[k];
        const Index v = anchor.vertex;
        positions.row(v) = previous.row(v);
        if (is_free(k)) continue;
        const auto rest = problem_.region.positions.row(v);
        if (targets.row(k) == rest && (!knows_former || former_soft_targets_.row(k) == rest)) {
            positions.row(v) = targets.row(k);
            continue;
        }
        const double weight = options_.weights != nullptr ? work_.levels.front().energy.soft_weights[k] : 1.0;
        const Eigen::RowVector3d lag = gradient.row(level.unknowns.slot[v]) / (2.0 * weight * anchor.strength);
        const double most = (targets.row(k) - previous.row(v)).norm();
        const double length = lag.norm();
        positions.row(v) += (length > most ? most / length : 1.0) * lag;
    }
}

/// Carries a shape that was near a minimum along with fixed vertices, and with the targets of soft constraints, that
/// have moved since: along their ways, in steps that are short enough for the answer to each to be nearly straight.
void FastSolve::follow_from(const Positions& previous, Positions& positions) {
    const Level level = whole();
    const std::size_t stage = level.bound.stages.size() - 1;
    Positions begins = previous;
    put_balanced_targets(previous, begins);
    Positions ends = positions;
    put_targets(ends);
    const HandlePaths::Path path = problem_.handles->path_between(begins, ends);
    const double far =
        std::max(path.largest_angle_rad() / kTurnOfResponse, path.largest_move() / (kMoveOfResponse * problem_.size));
    // Written so that what is not a number is one step.
    const int steps = far > 1.0 ? static_cast<int>(std::ceil(std::min<double>(far, kMostResponses))) : 1;
    Positions here = previous;
    for (int step = 1; step <= steps; ++step) {
        Positions next = here;
        place_along(path, static_cast<double>(step) / steps, level, next);
        respond(level, stage, here, next);
        here = std::move(next);
        if (step < steps) minimise(level, stage, lbfgs_options(kFollowTolerance, kStepsOfResponse, {}), here);
    }
    for (const Index v : level.bound.unknowns.free)
        positions.row(v) = here.row(v);
}

/// Goes on from the last answer of a drag, as the answers before tell; or from another shape.
void FastSolve::follow_drag(const Positions& previous, Positions& positions) {
    if (!goes_on_ && options_.in_drag) {
        Positions begins = previous;
        put_balanced_targets(previous, begins);
        work_.predictor.begin(previous, drivers_in(begins));
    }
    Positions predicted = previous;
    if (!goes_on_ || !work_.predictor.predict(drivers_of(positions), predicted, threads_, execution_)) {
        follow_from(previous, positions);
        return;
    }
    try {
        Positions answer = positions;
        follow_from(predicted, answer);
        std::swap(positions, answer);
        highest_start_ = kMostRise * work_.predictor.energy();
    } catch (const SolverFailure&) {
        set_soft_targets();
        follow_from(previous, positions);  // what was predicted is of no use
    }
}

/// Where a prediction was refused, as where the last change was a jump into another minimum: the lower of it and of
/// the start without it. @param energy of `positions`.
void FastSolve::follow_otherwise(const Positions& previous, double energy, Positions& positions) {
    Positions other = positions;
    follow_from(previous, other);
    if (!(energy <= energy_of(whole(), other))) std::swap(positions, other);
}

/// What drives the shape: the fixed vertices next to free ones, and the soft anchors, where they are in `positions`.
Positions FastSolve::drivers_in(const Positions& positions) const {
    const std::vector<Index>& fixed = problem_.levels.front()->stages.back().coupling.vertices;
    Positions drivers(static_cast<Eigen::Index>(fixed.size() + problem_.soft.size()), 3);
    Eigen::Index row = 0;
    for (const Index v : fixed)
        drivers.row(row++) = positions.row(v);
    for (const SoftAnchor& anchor : problem_.soft)
        drivers.row(row++) = positions.row(anchor.vertex);
    return drivers;
}

/// The same with the soft anchors at their targets.
Positions FastSolve::drivers_of(const Positions& positions) const {
    if (problem_.soft.empty()) return drivers_in(positions);
    Positions at_targets = positions;
    put_targets(at_targets);
    return drivers_in(at_targets);
}

}  // namespace meanvalue
