#include "meanvalue/decode/fast/fast_solve.h"

#include <algorithm>
#include <utility>

namespace meanvalue {
namespace {

// A start that is near a minimum takes fewer steps of the whole mesh.
constexpr int kMostWarmSteps = 60;
constexpr int kLookBack = 10;
constexpr double kStillFalling = 0.95;
// Iterations that lower the energy by less than so many step tolerances, as a share of it, end a solve: from rest,
// and after so many iterations in a drag, whose next frames make up for what is left in a valley.
constexpr double kEnergyTolerance = 50.0;
constexpr int kPatience = 20;
// Soft anchors that are stronger than this end a drag's history: with 1e6 it takes three times the iterations.
constexpr double kMostStrengthKept = 1e3;

}  // namespace

DecodeReport FastSolve::run(Positions& positions) {
    DecodeReport report;
    report.stop_reason = "no free vertices";
    if (problem_.levels.front()->unknowns.free.empty()) return report;
    execution_.begin_stage("solve");
    const std::vector<double> former_weights = work_.levels.front().energy.soft_weights;
    former_soft_targets_ = work_.levels.front().energy.soft_targets;
    set_soft_targets();
    if (work_.levels.front().energy.soft_weights !=
        former_weights) {  // another energy: what was learnt does not hold
        work_.predictor.forget();
        work_.keeps_history = false;
    }
    const bool is_cold = options_.previous == nullptr;
    goes_on_ = !is_cold && options_.in_drag && work_.predictor.has_answer();
    const int warm_limit = std::min(options_.max_iterations, kMostWarmSteps);
    const bool has_history = std::exchange(work_.keeps_history, false);
    bool keep_history = false;
    StopRule rule;
    if (is_cold) {
        rule = cold_rule();
        start_cold(positions);
    } else {
        const StageTimer timer(timings_, "follow");
        follow_drag(*options_.previous, positions);
        keep_history = goes_on_ && has_history && history_is_exact();
        if (goes_on_ && !options_.is_last) rule = drag_rule();
    }
    const auto minimise_whole = [&](int limit) {
        const StageTimer timer(timings_, "minimise");
        LbfgsOptions options = lbfgs_options(options_.tolerance, limit, rule);
        options.highest_start = std::exchange(highest_start_, std::numeric_limits<double>::infinity());
        options.keep_history = keep_history;
        return minimise(whole(), problem_.levels.front()->stages.size() - 1, options, positions);
    };
    LbfgsReport minimised = minimise_whole(is_cold ? options_.max_iterations : warm_limit);
    if (minimised.is_refused) {
        const StageTimer timer(timings_, "follow");
        follow_otherwise(*options_.previous, minimised.energies.front(), positions);
        minimised = minimise_whole(warm_limit);
    }
    if (!is_cold && minimised.at_limit && warm_limit < options_.max_iterations) {
        // Where the energy still falls, the start was not near a minimum, and one from rest costs less than what may
        // still be before this one. In a valley that was dragged into, it falls slowly: there the shape stays.
        const std::vector<double>& energies = minimised.energies;
        keep_history =
            !(problem_.rigidity > 0.0 && energies.back() < kStillFalling * energies[energies.size() - 1 - kLookBack]);
        if (!keep_history) {
            start_afresh_if_lower(energies.back(), positions);
            rule = {};
        }
        const LbfgsReport rest = minimise_whole(options_.max_iterations - warm_limit);
        minimised.energies.insert(minimised.energies.end(), rest.energies.begin() + 1, rest.energies.end());
        minimised.gradient = rest.gradient;
        minimised.converged = rest.converged;
        minimised.at_limit = rest.at_limit;
        minimised.left_off = rest.left_off;
    }
    if (!is_cold && options_.in_drag && !options_.is_last) {
        work_.predictor.note(positions, drivers_of(positions), minimised.energies.back());
        work_.keeps_history = true;
    }
    report.iterations = minimised.iterations();
    report.all_iterations = all_iterations_;
    report.energies = std::move(minimised.energies);
    report.initial_gradient = minimised.initial_gradient;
    report.gradient = minimised.gradient;
    report.converged = minimised.converged;
    report.stop_reason = minimised.converged  ? "converged"
                         : minimised.at_limit ? "iteration limit"
                         : minimised.left_off ? "left to the next solve"
                                              : "no step lowers the energy further";
    report.timings = std::move(timings_);
    return report;
}

FastSolve::StopRule FastSolve::cold_rule() const {
    return {problem_.rigidity > 0.0 ? kEnergyTolerance * options_.tolerance : 0.0, 0};
}

FastSolve::StopRule FastSolve::drag_rule() const {
    return {cold_rule().energy_tolerance, kPatience};
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
    options.adapt_scaling = &level.bound != problem_.levels.front().get();  // the whole mesh begins near its minimum
    LbfgsReport report =
        level.work.minimiser.minimise(energy, preconditioner_of(level, stage), options, positions, execution_);
    all_iterations_ += report.iterations();
    return report;
}

Preconditioner FastSolve::preconditioner_of(Level level, std::size_t stage) {
    const SupernodalFactor& factor = level.bound.stages[stage].factor;
    DiagonalDowndate& downdate = level.work.downdates[stage];
    const SoftConstraints& constraints = level.bound.energy->soft_constraints();
    const std::vector<double> lost = constraints.lost_hessian(level.work.energy.soft_weights);
    if (lost.empty()) {
        downdate.clear();
    } else {
        downdate.set(factor, constraints.rows(), lost, threads_, execution_, work_.factor);
    }
    return {factor, work_.factor, &downdate};
}

LbfgsOptions FastSolve::lbfgs_options(double tolerance, int max_iterations, const StopRule& rule) const {
    LbfgsOptions options;
    options.step_tolerance = tolerance * problem_.size;
    options.energy_tolerance = rule.energy_tolerance;
    options.patience = rule.patience;
    options.max_iterations = max_iterations;
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
        work.soft_weights =
            options_.weights != nullptr ? constraints.weights_of(*options_.weights) : std::vector<double>();
    }
    if (options_.weights != nullptr)
        pull_free_anchors_to(options_.previous != nullptr ? *options_.previous : problem_.region.positions);
}

/// Puts the targets of anchors that count nothing to where these are.
void FastSolve::pull_free_anchors_to(const Positions& positions) {
    for (std::size_t number = 0; number < problem_.levels.size(); ++number) {
        const std::vector<SoftAnchor>& anchors = problem_.levels[number]->energy->soft_constraints().anchors();
        DeformationEnergy::Workspace& work = work_.levels[number].energy;
        for (std::size_t k = 0; k < work.soft_weights.size(); ++k) {
            if (work.soft_weights[k] == 0.0) work.soft_targets.row(k) = positions.row(anchors[k].vertex);
        }
    }
}

void FastSolve::put_targets(Positions& positions) const {
    problem_.levels.front()->energy->soft_constraints().put(work_.levels.front().energy.soft_targets, positions);
}

/// Puts the fixed vertices of `positions` to where they are at `fraction` of the path, and moves the targets of soft
/// constraints along it.
void FastSolve::place_along(const HandlePaths::Path& path, double fraction, Level level, Positions& positions) {
    const SoftConstraints& constraints = level.bound.energy->soft_constraints();
    const Positions soft = constraints.rows_of(positions);
    path.place(fraction, positions);
    level.work.energy.soft_targets = constraints.rows_of(positions);
    constraints.put(soft, positions);
}

}  // namespace meanvalue
