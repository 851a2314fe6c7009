#include "meanvalue/decode/fast/fast_solve.h"

#include <algorithm>
#include <utility>

namespace meanvalue {
namespace {

// Iterations that lower the energy by less than so many step tolerances, as a share of it, end a solve: from
// rest, and after so many iterations in a drag, whose next frames make up for what is left in a valley.
constexpr double kEnergyTolerance = 50.0;
constexpr int kPatience = 20;
// Of the tolerance: that of answers that no next solve makes up for.
constexpr double kOfKept = 0.1;
// Soft anchors that are stronger than this end a drag's history: with 1e6 it takes three times the iterations.
constexpr double kMostStrengthKept = 1e3;
// Rounds of fitting examples and solving on the coarsest level, with as many iterations each as patience has, when a
// solve begins at an earlier answer; more of them cost more than they bring. They end when no weight changes by more
// than this.
constexpr int kWarmRounds = 2;
constexpr double kSettledWeights = 0.003;

}  // namespace

/// From now on the rest shape alone is kept.
void FastSolve::forget_examples() {
    work_.example_weights.resize(0, 0);
    for (FastWorkspace::OfLevel& of_level : work_.levels)
        of_level.energy.rows.reset();
}

/// Fits the weights of the examples to a shape. @return how much the farthest one changed.
double FastSolve::fit_examples(Level level, const Positions& shape) {
    ExampleWeights weights = level.bound.examples->fit(shape, threads_, execution_);
    if (work_.example_weights.size() == 0) work_.example_weights.setZero(weights.rows(), weights.cols());
    const double change = (weights - work_.example_weights).cwiseAbs().maxCoeff();
    work_.example_weights = std::move(weights);
    return change;
}

/// The level keeps the blend by these weights from now on.
void FastSolve::blend_examples(Level level) {
    if (work_.example_weights.size() == 0) return;
    if (level.work.blended.ring.empty()) {
        level.work.blended = *level.bound.encoding;
        level.work.blended_cells.edges.resize(level.work.blended.ring.size());
    }
    level.bound.examples->blend(work_.example_weights, threads_, execution_, level.work.blended,
                                level.work.blended_cells);
    level.bound.energy->refill(level.work.blended, level.work.blended_cells, threads_, execution_, level.work.energy);
}

/// Fits and solves in turns.
void FastSolve::relax_with_examples(Level level, int most_rounds, Positions& positions) {
    for (int round = 0; round < most_rounds; ++round) {
        const double change = fit_examples(level, positions);
        blend_examples(level);
        minimise(level, level.bound.stages.size() - 1, lbfgs_options(kPatience), positions);
        if (change < kSettledWeights) break;
    }
}

DecodeReport FastSolve::run(Positions& positions) {
    DecodeReport report;
    report.stop_reason = "no free vertices";
    if (problem_.levels.front()->unknowns.free.empty()) return report;
    execution_.begin_stage("solve");
    const std::vector<double> former_weights = work_.levels.front().energy.soft_weights;
    if (options_.is_kept && options_.previous != nullptr) begin_at_rest_if_free();
    set_soft_targets();
    Positions from_rest;  // none: not begun
    const bool is_cold =
        options_.previous == nullptr || (options_.is_kept && !leads_where_rest_does(positions, from_rest));
    // Another valley, or energy: the history is of no use.
    const bool leaves = is_cold && options_.previous != nullptr;
    if (leaves || work_.levels.front().energy.soft_weights != former_weights) {
        const std::lock_guard<std::mutex> lock(work_.drafting);
        work_.predictor.forget();
        work_.responses.forget();
        work_.is_drafting = work_.keeps_history = false;
    }
    goes_on_ = !is_cold && options_.in_drag && work_.predictor.has_answer();
    if (has_examples() && !goes_on_) forget_examples();
    const bool has_history = std::exchange(work_.keeps_history, false);
    LbfgsOptions lbfgs = lbfgs_options(options_.max_iterations);
    const auto go_to_the_end = [&] {
        lbfgs.energy_tolerance = 0.0;
        if (options_.is_kept || options_.is_last) lbfgs.step_tolerance *= kOfKept;
    };
    if (is_cold) {
        start_cold(from_rest, positions);
    } else {
        const StageTimer timer(timings_, "follow");
        start_warm(*options_.previous, positions);
        if (has_examples()) {
            Positions coarse = positions;
            relax_with_examples(coarsest(), kWarmRounds, coarse);
            blend_examples(whole());
        }
        const bool goes_further = goes_on_ && !options_.is_last;
        if (!goes_further || options_.is_kept) go_to_the_end();
        lbfgs.enough_energy = options_.enough_energy;
        lbfgs.patience = goes_further ? kPatience : 0;
        lbfgs.keep_history = goes_on_ && has_history && history_is_exact();
    }
    const auto minimise_whole = [&] {
        const StageTimer timer(timings_, "minimise");
        return minimise(whole(), problem_.levels.front()->stages.size() - 1, lbfgs, positions);
    };
    LbfgsReport minimised = minimise_whole();
    const bool goes_to_the_end = is_cold && (options_.is_kept || options_.is_last);
    if (goes_to_the_end) go_to_the_end();
    if (has_examples() && !goes_on_) {
        fit_examples(whole(), positions);
        blend_examples(whole());
    }
    if (goes_to_the_end || (has_examples() && !goes_on_)) minimised = minimise_whole();
    report.iterations = minimised.iterations();
    report.all_iterations = all_iterations_;
    report.energies = std::move(minimised.energies);
    report.initial_gradient = minimised.initial_gradient;
    report.gradient = minimised.gradient;
    report.example_weights = work_.example_weights;
    report.converged = minimised.converged;
    report.stop_reason = minimised.converged  ? "converged"
                         : minimised.at_limit ? "iteration limit"
                                              : "no step lowers the energy further";
    report.timings = std::move(timings_);
    return report;
}

/// Pairs in single precision tell nothing of the rest of the energy beside soft constraints that are far stiffer.
bool FastSolve::history_is_exact() const {
    return std::all_of(problem_.soft.begin(), problem_.soft.end(),
                       [](const SoftAnchor& anchor) { return anchor.strength <= kMostStrengthKept; });
}

LbfgsReport FastSolve::minimise(Level level, std::size_t stage, LbfgsOptions options, Positions& positions) {
    const FastStage& at = level.bound.stages[stage];
    const auto energy = [&](const Positions& positions_then, Positions& gradient) {
        return level.bound.energy->evaluate(positions_then, at.rigidity, gradient, threads_, execution_,
                                            level.work.energy);
    };
    options.threads = threads_;
    LbfgsReport report =
        level.work.minimiser.minimise(energy, preconditioner_of(level, stage), options, positions, execution_);
    all_iterations_ += report.iterations();
    return report;
}

Preconditioner FastSolve::preconditioner_of(Level level, std::size_t stage) {
    const SupernodalFactor& factor = level.bound.stages[stage].factor;
    DiagonalDowndate& downdate = level.work.downdates[stage];
    const SoftConstraints& constraints = level.bound.energy->soft_constraints();
    downdate.set(factor, constraints.rows(), constraints.lost_hessian(level.work.energy.soft_weights), threads_,
                 execution_, work_.factor);
    return {factor, work_.factor, &downdate};
}

LbfgsOptions FastSolve::lbfgs_options(int max_iterations, double least_tolerance) const {
    LbfgsOptions options;
    options.step_tolerance = std::max(options_.tolerance, least_tolerance) * problem_.size;
    options.energy_tolerance = problem_.rigidity > 0.0 ? kEnergyTolerance * options_.tolerance : 0.0;
    options.max_iterations = std::min(max_iterations, options_.max_iterations);
    return options;
}

double FastSolve::energy_of(Level level, const Positions& positions) {
    Positions gradient(static_cast<Eigen::Index>(level.bound.unknowns.free.size()), 3);
    return level.bound.energy->evaluate(positions, problem_.rigidity, gradient, threads_, execution_,
                                        level.work.energy);
}

void FastSolve::set_soft_targets() {
    for (std::size_t number = 0; number < problem_.levels.size(); ++number) {
        const SoftConstraints& constraints = problem_.levels[number]->energy->soft_constraints();
        if (constraints.empty()) continue;
        DeformationEnergy::Workspace& work = work_.levels[number].energy;
        work.soft_targets = constraints.targets_of(*options_.targets);
        work.soft_weights.clear();
        if (options_.weights != nullptr) work.soft_weights = constraints.weights_of(*options_.weights);
        // As if none were given: others may have been given for the sake of another part.
        const auto count = static_cast<std::ptrdiff_t>(work.soft_weights.size());
        if (std::count(work.soft_weights.begin(), work.soft_weights.end(), 1.0) == count) work.soft_weights.clear();
    }
    if (options_.weights != nullptr)
        pull_free_anchors_to(options_.previous != nullptr ? *options_.previous : problem_.rest);
}

/// Puts the targets of anchors that count nothing to where these are.
void FastSolve::pull_free_anchors_to(const Positions& positions) {
    for (std::size_t number = 0; number < problem_.levels.size(); ++number) {
        const std::vector<Index>& vertices = problem_.levels[number]->energy->soft_constraints().vertices();
        DeformationEnergy::Workspace& work = work_.levels[number].energy;
        for (std::size_t k = 0; k < work.soft_weights.size(); ++k) {
            if (work.soft_weights[k] == 0.0) work.soft_targets.row(k) = positions.row(vertices[k]);
        }
    }
}

/// Puts the fixed vertices of `positions` to where they are at `fraction` of the path, and moves the targets of soft
/// constraints along it.
void FastSolve::place_along(const HandlePaths::Path& path, double fraction, Level level, Positions& positions) {
    const SoftConstraints& constraints = level.bound.energy->soft_constraints();
    const Positions soft = constraints.rows_of(positions);
    path.place(fraction, positions);
    level.work.energy.soft_targets = constraints.rows_of(positions);
    positions(constraints.vertices(), Eigen::all) = soft;
}

}  // namespace meanvalue
