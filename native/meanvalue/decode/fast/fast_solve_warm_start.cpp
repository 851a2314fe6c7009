// FastSolve from an earlier answer, as while dragging.
#include <utility>

#include "meanvalue/common/tolerances.h"
#include "meanvalue/decode/fast/fast_solve.h"

namespace meanvalue {
namespace {

// Of the tolerance: what moves by less is not answered.
constexpr double kLeastMove = 0.01;
// Of the size: smaller ones are lost in the coarsest level's tolerance.
constexpr double kLeastCoarseMove = 1e-3;
// The coarsest level's change is sound if the initial Hessian's answer is within this share of the way from it.
constexpr double kSoundCoarse = 0.8;
// Shares of the energy: at which a fall ends a solve that asks for the valley alone, and that another one is lower
// by.
constexpr double kNearValley = 1e-4;
constexpr double kLower = 1e-3;

}  // namespace

Positions drivers_of(const FastLevel& level, const Positions& positions, const Positions& soft) {
    const std::vector<Index>& fixed = level.stages.back().coupling.vertices;
    Positions result(static_cast<Eigen::Index>(fixed.size()) + soft.rows(), 3);
    result << positions(fixed, Eigen::all), soft;
    return result;
}

/// The initial Hessian's answer, |V'| x 3, to moves of the drivers (d x 3).
Positions FastSolve::hessian_answer(Level level, std::size_t stage, const Positions& moves) {
    const FixedCoupling& coupling = level.bound.stages[stage].coupling;
    Positions answer = -(coupling.matrix * moves.topRows(static_cast<Eigen::Index>(coupling.vertices.size())));
    level.bound.energy->soft_constraints().add_pulls(moves, level.work.energy.soft_weights, answer);
    preconditioner_of(level, stage).solve(answer, answer, threads_, execution_);
    return answer;
}

/// Moves the free vertices by what the initial Hessian answers to moves of the drivers (d x 3): the least energy of
/// all displacements, as far as it is the same in every pose. Where an anchor moves alone, its surroundings are torn
/// instead, and minimizing has to begin from a spike.
void FastSolve::respond(Level level, std::size_t stage, const Positions& moves, Positions& positions) {
    if (moves.isZero(0.0)) return;
    positions(level.bound.unknowns.free, Eigen::all) += hessian_answer(level, stage, moves);
}

/// Where none of its anchors counts, it begins at rest: no energy would lead there.
void FastSolve::begin_at_rest_if_free() {
    if (options_.weights == nullptr || problem_.soft.empty()) return;
    const std::vector<double> carrying = carrying_weights();
    for (std::size_t v = 0; v < carrying.size(); ++v)
        if (problem_.is_anchor[v] && carrying[v] > kNegligible) return;
    options_.previous = &problem_.rest;
}

/// Whether the answer before leads, on the coarsest level, to an energy as low as a solve from rest does. Where that
/// is the whole mesh, rest is asked alone. @param goal n x 3, the fixed vertices. @param from_rest receives the start
/// from rest, where it was made and leads elsewhere.
bool FastSolve::leads_where_rest_does(const Positions& goal, Positions& from_rest) {
    if (problem_.levels.size() < 2 || has_examples()) return false;
    const Level level = coarsest();
    LbfgsOptions options = lbfgs_options(options_.max_iterations);
    options.energy_tolerance = kNearValley;
    const auto energy_at_end = [&](Positions& shape) {
        return minimise(level, level.bound.stages.size() - 1, options, shape).energies.back();
    };
    Positions led = goal;
    for (const Index v : level.bound.unknowns.free)
        led.row(v) = options_.previous->row(v);
    const Positions soft = level.bound.energy->soft_constraints().rows_of(*options_.previous);
    const Positions moves = drivers_of(level.bound, goal, level.work.energy.soft_targets) -
                            drivers_of(level.bound, *options_.previous, soft);
    respond(level, level.bound.stages.size() - 1, moves, led);
    const double energy = energy_at_end(led);
    from_rest = goal;
    start_from_rest(from_rest);
    Positions at_end = from_rest;
    if (energy_at_end(at_end) <= (1.0 - kLower) * energy) return false;
    set_soft_targets();  // those of free anchors were where rest has them
    return true;
}

double FastSolve::least_move() const {
    return kLeastMove * options_.tolerance * problem_.size;
}

/// Keeps the initial Hessian's answers to handles that begin to move. @param moves d x 3.
void FastSolve::ask_for_responses(const Positions& moves) {
    if (!work_.levels.front().energy.soft_weights.empty()) return;
    const std::vector<Index> moving = work_.responses.moving(moves, least_move());
    const std::vector<Index> handles = work_.responses.unknown(moving);
    if (handles.empty()) return;
    const auto hessian = [&](const Positions& moved) {
        return hessian_answer(whole(), whole().bound.stages.size() - 1, moved);
    };
    std::vector<HandleResponses::Fields> fields = work_.responses.ask(handles, hessian);
    const std::lock_guard<std::mutex> lock(work_.drafting);
    work_.responses.keep(handles, std::move(fields), moving);
}

void FastSolve::begin_drag(const Positions& previous) {
    const std::lock_guard<std::mutex> lock(work_.drafting);
    work_.predictor.begin(
        previous, drivers_of(whole().bound, previous, work_.predictor.soft_drivers(previous, soft_targets())));
    work_.is_drafting = work_.levels.front().energy.soft_weights.empty();
}

/// Where no change is known yet, what the coarsest level makes of the move is taken for one: a tenth to a fifth off,
/// where the initial Hessian's answer is a half. @param moves d x 3; @param goal n x 3, its fixed vertices.
void FastSolve::suppose_coarse_change(const Positions& moves, const Positions& previous, const Positions& goal) {
    const bool is_worth_it = moves.size() > 0 && moves.cwiseAbs().maxCoeff() > kLeastCoarseMove * problem_.size;
    // The levels pull soft anchors to where they go, so that the shape before is not known.
    const bool has_soft_moves = !moves.bottomRows(soft_targets().rows()).isZero(0.0);
    const bool has_weights = !work_.levels.front().energy.soft_weights.empty();  // often others in each frame
    if (!is_worth_it || has_soft_moves || has_weights || problem_.levels.size() < 2) return;
    const Level level = coarsest();
    Positions before = previous;
    relax(level, before);
    Positions after = before;
    for (std::size_t v = 0; v < problem_.is_fixed.size(); ++v) {
        if (problem_.is_fixed[v]) after.row(v) = goal.row(v);
    }
    const Positions soft = level.bound.energy->soft_constraints().rows_of(before);
    const Positions coarse_moves = drivers_of(level.bound, after, soft) - drivers_of(level.bound, before, soft);
    respond(level, level.bound.stages.size() - 1, coarse_moves, after);
    const Positions answered = after;
    relax(level, after);
    const bool is_sound = (after - answered).norm() < kSoundCoarse * (after - before).norm();
    for (Positions* const shape : {&before, &after}) {
        for (auto coarse = problem_.hierarchy->levels.rbegin(); coarse != problem_.hierarchy->levels.rend(); ++coarse)
            coarse->splits.carry(problem_.rest, *shape, threads_, execution_);
    }
    const std::lock_guard<std::mutex> lock(work_.drafting);
    work_.predictor.suppose(after - before, moves, is_sound);
}

/// Goes on from the last answer of a drag, as the answers before predict, or from another shape. What the drivers
/// move besides is answered by the initial Hessian.
void FastSolve::start_warm(const Positions& previous, Positions& positions) {
    const FastLevel& level = whole().bound;
    const Positions goal = drivers_of(level, positions, soft_targets());
    Positions start = previous;
    Positions moves = goal;
    if (options_.in_drag) {
        if (!goes_on_) begin_drag(previous);
        const Positions all_moves = goal - work_.predictor.drivers();
        ask_for_responses(all_moves);
        if (!work_.predictor.has_changes()) suppose_coarse_change(all_moves, previous, positions);
        moves -= work_.predictor.predict(goal, start, threads_, execution_);
        work_.responses.answer(moves, level.unknowns, start, threads_, execution_);
    } else {
        moves -= drivers_of(level, previous, soft_targets());
    }
    for (const Index v : level.unknowns.free)
        positions.row(v) = start.row(v);
    if (moves.size() > 0 && !(moves.cwiseAbs().maxCoeff() <= least_move()))
        respond(whole(), level.stages.size() - 1, moves, positions);
    if (options_.in_drag) work_.predictor.expect(positions);
}

}  // namespace meanvalue
