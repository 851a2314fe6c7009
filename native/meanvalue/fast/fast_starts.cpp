// Where FastDecoder begins: from rest, coarse to fine, or from a shape that is near the minimum.
#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/fast/fast_decoder.h"
#include "meanvalue/solver/carry_parts.h"

namespace meanvalue {
namespace {

// Stages on the way, as shares of the size and in steps.
constexpr double kStageTolerance = 2e-4;
constexpr double kStiffTolerance = 5e-4;
constexpr int kMostStageSteps = 40;
// Handles that turn farther than this (120 degrees) are also followed along their way, in steps of at most the second
// angle. Nearer ones are found as well from the stiff stages; docs/algorithm.md has the count.
constexpr double kFarTurn = 2.1;
constexpr double kTurnOfStep = 0.26;
constexpr int kMostFollowSteps = 15;
constexpr double kFollowTolerance = 1e-3;
// With a start, handles that turn or move farther than this, the move as a share of the size, are followed in steps.
constexpr double kTurnOfResponse = 0.3;
constexpr double kMoveOfResponse = 0.05;
constexpr int kMostResponses = 24;
constexpr int kStepsOfResponse = 5;
// A predicted start may be so many times as high as the last answer; else the other start is looked at too.
constexpr double kMostRise = 2.0;

/// Puts the fixed vertices of `positions` to where they are at `fraction` of the way, and pulls springs along it.
void place_along(const RigidPieces::Way& way, double fraction, Springs& springs, Positions& positions) {
    springs.set_aside(positions);
    way.place(fraction, positions);
    springs.aim_at_vertices(positions);
    springs.put_back(positions);
}

}  // namespace

/// Places the free vertices from the rest shape, coarse to fine, so that the whole mesh remains to be minimised.
void FastDecoder::start_cold(const DecodeOptions& options, Positions& positions, Timings& timings,
                             Execution& execution) {
    energy_tolerance_ = energy_tolerance_of(options);
    patience_ = 0;
    {
        const StageTimer timer(timings, "start");
        start_from_rest(options.tolerance, options.max_iterations, positions, execution);
    }
    if (!coarse_) return;
    const StageTimer timer(timings, "split");
    int level = static_cast<int>(hierarchy_.levels.size()) - 1;
    if (middle_) {
        hierarchy_.carry(level, 0, region_.positions, positions, threads_, execution);
        level = 0;
        minimise(*middle_, 0, std::max(options.tolerance, kStageTolerance), options.max_iterations, positions,
                 execution);
    }
    hierarchy_.carry(level, -1, region_.positions, positions, threads_, execution);
}

/// Starts from rest, and keeps that where it is below `energy`, that of `positions`.
void FastDecoder::start_afresh_if_lower(const DecodeOptions& options, double energy, Positions& positions,
                                        Timings& timings, Execution& execution) {
    aim_springs(options);
    Positions fresh = positions;
    fine_->energy->springs().put_targets(fresh);
    try {
        start_cold(options, fresh, timings, execution);
    } catch (const SolverFailure&) {
        fresh = positions;  // what was found stays
    }
    energy_tolerance_ = 0.0;
    aim_springs(options);
    if (energy_of(*fine_, fresh, execution) < energy) std::swap(positions, fresh);
}

void FastDecoder::aim_springs(const DecodeOptions& options) {
    for (SolverLevel* level : {fine_.get(), middle_.get(), coarse_.get()}) {
        if (level != nullptr && !level->energy->springs().empty())
            level->energy->springs().aim_at_targets(*options.targets);
    }
}

/// Moves the free vertices by what the constant matrix answers to the moves of the fixed ones: the least energy of
/// all displacements, as far as it is the same in every pose. Where an anchor moves alone, its surroundings are torn
/// instead, and minimising has to begin from a spike. @param previous where the fixed vertices were; in `positions`
/// they are where they go, and free ones where they were.
void FastDecoder::respond(SolverLevel& level, std::size_t stage, const Positions& previous, Positions& positions,
                          const Execution& execution) const {
    const FixedCoupling& coupling = level.stages[stage]->coupling;
    Positions moves(static_cast<Eigen::Index>(coupling.vertices.size()), 3);
    for (std::size_t k = 0; k < coupling.vertices.size(); ++k)
        moves.row(k) = positions.row(coupling.vertices[k]) - previous.row(coupling.vertices[k]);
    if (moves.isZero(0.0)) return;
    Positions answer = -(coupling.matrix * moves);
    level.stages[stage]->factor.solve(answer, answer, threads_, execution);
    for (std::size_t k = 0; k < level.unknowns.free.size(); ++k)
        positions.row(level.unknowns.free[k]) += answer.row(k);
}

/// Puts soft anchors to where the targets were that they were in balance with at `previous`: behind them by as much
/// as the rest of the energy pulls there. Not farther off than the present targets are, if it was no balance at all.
void FastDecoder::put_balanced_targets(const Positions& previous, Positions& positions, Execution& execution) {
    if (soft_.empty()) return;
    Springs& springs = fine_->energy->springs();
    Positions targets = previous;
    springs.put_targets(targets);
    springs.aim_at_vertices(previous);
    Positions gradient(static_cast<Eigen::Index>(fine_->unknowns.free.size()), 3);
    fine_->energy->evaluate(previous, rigidity_, gradient, threads_, execution);
    springs.aim_at_vertices(targets);
    for (const SoftAnchor& anchor : soft_) {
        const Index v = anchor.vertex;
        const Eigen::RowVector3d lag = gradient.row(fine_->unknowns.slot[v]) / (2.0 * anchor.strength);
        const double most = (targets.row(v) - previous.row(v)).norm();
        const double length = lag.norm();
        positions.row(v) = previous.row(v) + (length > most ? most / length : 1.0) * lag;
    }
}

/// Carries a shape that was near a minimum along with fixed vertices, and with the targets of springs, that have
/// moved since: along their ways, in steps that are short enough for the answer to each to be nearly straight.
void FastDecoder::follow_from(const Positions& previous, Positions& positions, Execution& execution) {
    SolverLevel& level = *fine_;
    const std::size_t stage = level.stages.size() - 1;
    Springs& springs = level.energy->springs();
    Positions begins = previous;
    put_balanced_targets(previous, begins, execution);
    Positions ends = positions;
    springs.put_targets(ends);
    const RigidPieces::Way way = pieces_->way_between(begins, ends);
    const double far =
        std::max(way.largest_angle_rad() / kTurnOfResponse, way.largest_move() / (kMoveOfResponse * size_));
    // Written so that what is not a number is one step.
    const int steps = far > 1.0 ? static_cast<int>(std::ceil(std::min<double>(far, kMostResponses))) : 1;
    Positions here = previous;
    for (int step = 1; step <= steps; ++step) {
        Positions next = here;
        place_along(way, static_cast<double>(step) / steps, springs, next);
        respond(level, stage, here, next, execution);
        here = std::move(next);
        if (step < steps) minimise(level, stage, kFollowTolerance, kStepsOfResponse, here, execution);
    }
    for (const Index v : level.unknowns.free)
        positions.row(v) = here.row(v);
}

/// Goes on from the answer of the last solve, if that is what `previous` is, as the answers before tell; or from
/// another shape. @return whether it is.
bool FastDecoder::follow_drag(const Positions& previous, Positions& positions, Execution& execution) {
    const bool goes_on = predictor_.goes_on_from(previous);
    if (!goes_on) {
        Positions begins = previous;
        put_balanced_targets(previous, begins, execution);
        predictor_.begin(previous, drivers_in(begins));
    }
    Positions predicted = previous;
    if (!goes_on || !predictor_.predict(drivers_of(positions), predicted, threads_, execution)) {
        follow_from(previous, positions, execution);
        return goes_on;
    }
    try {
        Positions answer = positions;
        follow_from(predicted, answer, execution);
        std::swap(positions, answer);
        highest_start_ = kMostRise * predictor_.energy();
    } catch (const SolverFailure&) {
        follow_from(previous, positions, execution);  // what was predicted is of no use
    }
    return goes_on;
}

/// Where a prediction was refused, as where the last change was a jump into another minimum: the lower of it and of
/// the start without it. @param energy of `positions`.
void FastDecoder::follow_otherwise(const Positions& previous, double energy, Positions& positions,
                                   Execution& execution) {
    Positions other = positions;
    follow_from(previous, other, execution);
    if (!(energy <= energy_of(*fine_, other, execution))) std::swap(positions, other);
}

/// What drives the shape: the fixed vertices next to free ones, and the soft anchors, where they are in `positions`.
Positions FastDecoder::drivers_in(const Positions& positions) const {
    const std::vector<Index>& fixed = fine_->stages.back()->coupling.vertices;
    Positions drivers(static_cast<Eigen::Index>(fixed.size() + soft_.size()), 3);
    Eigen::Index row = 0;
    for (const Index v : fixed)
        drivers.row(row++) = positions.row(v);
    for (const SoftAnchor& anchor : soft_)
        drivers.row(row++) = positions.row(anchor.vertex);
    return drivers;
}

/// The same with the soft anchors at their targets.
Positions FastDecoder::drivers_of(const Positions& positions) const {
    if (soft_.empty()) return drivers_in(positions);
    Positions at_targets = positions;
    fine_->energy->springs().put_targets(at_targets);
    return drivers_in(at_targets);
}

double FastDecoder::energy_of(SolverLevel& level, const Positions& positions, const Execution& execution) const {
    Positions gradient(static_cast<Eigen::Index>(level.unknowns.free.size()), 3);
    return level.energy->evaluate(positions, rigidity_, gradient, threads_, execution);
}

/// From rest, carried along with the fixed vertices.
void FastDecoder::start_from_rest(double tolerance, int max_iterations, Positions& positions, Execution& execution) {
    const RigidPieces::Way way = pieces_->way_to(positions);
    execution.check();
    const Positions carried = carry_parts(components_, region_.positions, positions, hold_);
    execution.check();
    for (std::size_t v = 0; v < region_.is_fixed.size(); ++v) {
        if (!region_.is_fixed[v]) positions.row(v) = carried.row(v);
    }
    SolverLevel& level = starting_level();
    const std::size_t last = level.stages.size() - 1;
    respond(level, 0, carried, positions, execution);
    const Positions start = positions;
    double energy = relax_stage_by_stage(tolerance, max_iterations, positions, execution);
    const auto keep_if_lower = [&](Positions& other, double other_energy) {
        if (!(other_energy < energy)) return;
        energy = other_energy;
        std::swap(positions, other);
    };
    // Stiff stages lead away from shapes that are perfect but larger or smaller.
    if (energy_of(level, start, execution) < energy) {
        Positions carried_on = start;
        const QuasiNewtonReport report =
            minimise(level, last, std::max(tolerance, kStageTolerance), max_iterations, carried_on, execution);
        keep_if_lower(carried_on, report.energies.back());
    }
    if (way.largest_angle_rad() > kFarTurn) {
        Positions followed = region_.positions;
        const double followed_energy = follow(way, tolerance, max_iterations, followed, execution);
        keep_if_lower(followed, followed_energy);
    }
}

double FastDecoder::relax_stage_by_stage(double tolerance, int max_iterations, Positions& positions,
                                         Execution& execution) {
    SolverLevel& level = starting_level();
    for (std::size_t stage = 0; stage + 1 < level.stages.size(); ++stage)
        minimise(level, stage, kStiffTolerance, kMostStageSteps, positions, execution);
    return minimise(level, level.stages.size() - 1, std::max(tolerance, kStageTolerance), max_iterations, positions,
                    execution)
        .energies.back();
}

double FastDecoder::follow(const RigidPieces::Way& way, double tolerance, int max_iterations, Positions& positions,
                           Execution& execution) {
    SolverLevel& level = starting_level();
    const int steps = static_cast<int>(std::ceil(way.largest_angle_rad() / kTurnOfStep));
    Springs& springs = level.energy->springs();
    for (int step = 1; step < steps; ++step) {
        place_along(way, static_cast<double>(step) / steps, springs, positions);
        minimise(level, level.stages.size() - 1, kFollowTolerance, kMostFollowSteps, positions, execution);
    }
    place_along(way, 1.0, springs, positions);
    return minimise(level, level.stages.size() - 1, std::max(tolerance, kStageTolerance), max_iterations, positions,
                    execution)
        .energies.back();
}

}  // namespace meanvalue
