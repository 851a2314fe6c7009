#include "meanvalue/optimise/lbfgs.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/optimise/line_search.h"

namespace meanvalue {
namespace {

constexpr int kMostHalvings = 20;
// A step at whose end the slope is more than this share of that at its start is lengthened, so many times at most.
constexpr double kSteep = 0.3;
constexpr double kLongest = 4.0;
// The initial Hessian is divided by the product of the steps' lengths so far: in what the history knows nothing of,
// it is twice as stiff as the energy where much rotates, and each step would have to be lengthened anew, by an
// evaluation more. By so much at most.
constexpr double kLargestScaling = 3.0;
// Steps this short in a row are the end; a single one may be a bad step.
constexpr int kShortSteps = 2;
// With patience, what comes after a single step that is shorter than this, in step tolerances, does not matter even
// where the energy falls: there is little of it, and the next solve goes on. Half of a smooth drag's iterations.
constexpr double kOutOfSight = 0.3;
// A step of an inherited history that has to be shortened to less ends it.
constexpr double kMisled = 0.125;
// With an energy tolerance: the iterations that it is about, and how short the last has to be, in step tolerances.
constexpr int kSlowSteps = 4;
constexpr double kNearlyShort = 4.0;
// After twice the patience so many times as much may be left.
constexpr double kLate = 20.0;

/// Whether the last `steps` iterations together lowered the energy by more than `share` of it.
bool falls(const std::vector<double>& energies, std::size_t steps, double share) {
    return energies.size() <= steps || energies.back() < (1.0 - share) * energies[energies.size() - 1 - steps];
}

/// The energy tolerance that counts at an iteration; 0: none.
double energy_share(const LbfgsOptions& options, int iteration) {
    if (iteration < options.patience) return 0.0;
    const bool is_late = options.patience > 0 && iteration >= 2 * options.patience;
    return (is_late ? kLate : 1.0) * options.energy_tolerance;
}

}  // namespace

Lbfgs::Lbfgs(const Unknowns& unknowns, double size) : unknowns_(&unknowns) {
    const auto count = static_cast<Eigen::Index>(unknowns.free.size());
    // Without writing to them: filling hundreds of megabytes takes longer than a cancel may wait. All is written
    // before it is read.
    for (Positions* vectors : {&gradient_, &trial_gradient_, &farther_gradient_, &direction_})
        vectors->resize(count, 3);
    history_ = LbfgsHistory(static_cast<Index>(count), size);
}

LbfgsReport Lbfgs::minimise(const Energy& energy, const Preconditioner& preconditioner, const LbfgsOptions& options,
                            Positions& positions, Execution& execution) {
    LbfgsReport report;
    if (!options.keep_history) history_.clear();
    bool is_inherited = !history_.empty();
    trial_ = positions;
    double value = energy(positions, gradient_);
    if (!std::isfinite(value)) throw SolverFailure("the energy of the start is not finite");
    report.energies.push_back(value);
    report.initial_gradient = gradient_.norm();
    int short_steps = 0;
    double scaling = 1.0;
    while (gradient_.squaredNorm() > 0.0) {
        if (report.iterations() == options.max_iterations) {
            report.at_limit = true;
            break;
        }
        execution.check();
        execution.set_progress(static_cast<double>(report.iterations()) / options.max_iterations);
        history_.find_direction(gradient_, preconditioner, scaling, options.threads, execution, direction_);
        const double slope = (direction_.cwiseProduct(gradient_)).sum();
        const double longest = std::sqrt(direction_.rowwise().squaredNorm().maxCoeff());
        double length = slope < 0.0 ? 1.0 : 0.0;
        double trial_value = value;
        for (int halving = 0; length > 0.0; ++halving, length = halving > kMostHalvings ? 0.0 : 0.5 * length) {
            move_free(length, positions, trial_, options.threads, execution);
            trial_value = energy(trial_, trial_gradient_);
            if (falls_enough(value, trial_value, length * slope)) break;
        }
        is_inherited = is_inherited && report.iterations() < LbfgsHistory::kPairs;
        if (length < kMisled && is_inherited) {
            // The history of another solve misleads here.
            history_.clear();
            scaling = 1.0;
            is_inherited = false;
            continue;
        }
        if (length == 0.0) {
            if (history_.empty() && scaling == 1.0) {
                // At the minimum but for rounding, or stuck.
                report.converged = longest < options.step_tolerance;
                break;
            }
            history_.clear();  // it may be misleading: once more without it
            scaling = 1.0;
            continue;
        }
        if (length == 1.0) lengthen(energy, options.threads, value, slope, positions, execution, length, trial_value);
        if (options.adapt_scaling) scaling = std::clamp(scaling * length, 1.0, kLargestScaling);
        history_.remember(length, direction_, gradient_, trial_gradient_, options.threads, execution);
        std::swap(positions, trial_);
        std::swap(gradient_, trial_gradient_);
        value = trial_value;
        report.energies.push_back(value);
        const double step = length * longest;
        short_steps = step < options.step_tolerance ? short_steps + 1 : 0;
        const double share = energy_share(options, report.iterations());
        // The whole step: one that had to be shortened tells nothing.
        const double out_of_sight = options.patience > 0 ? kOutOfSight * options.step_tolerance : 0.0;
        const bool is_out_of_sight = std::max(step, longest) < out_of_sight;
        const bool still_falls =
            options.energy_tolerance > 0.0 && falls(report.energies, kShortSteps, options.energy_tolerance);
        if (is_out_of_sight || (short_steps >= kShortSteps && !still_falls)) {
            report.converged = true;
            break;
        }
        if (share > 0.0 && step < kNearlyShort * options.step_tolerance &&
            !falls(report.energies, kSlowSteps, share)) {
            report.converged = share == options.energy_tolerance;
            report.left_off = !report.converged && short_steps < kShortSteps;
            break;
        }
    }
    report.converged = report.converged || short_steps >= kShortSteps || gradient_.squaredNorm() == 0.0;
    report.gradient = gradient_.norm();
    return report;
}

/// Goes on along a step on which the energy still falls nearly as steeply at its end as at its start: to where a
/// parabola by both slopes has its minimum. The initial Hessian is too stiff for limbs that rotate as a whole, and
/// this costs no solve. @param length, trial_value of the step in `trial_`; both change with it.
void Lbfgs::lengthen(const Energy& energy, int threads, double value, double slope, const Positions& positions,
                     const Execution& execution, double& length, double& trial_value) {
    const double steepness = direction_.cwiseProduct(trial_gradient_).sum() / slope;
    if (!(steepness > kSteep)) return;
    const double longer = steepness < 1.0 - 1.0 / kLongest ? 1.0 / (1.0 - steepness) : kLongest;
    farther_ = positions;
    move_free(longer, positions, farther_, threads, execution);
    const double farther_value = energy(farther_, farther_gradient_);
    if (!(farther_value < trial_value && falls_enough(value, farther_value, longer * slope))) return;
    length = longer;
    trial_value = farther_value;
    std::swap(trial_, farther_);
    std::swap(trial_gradient_, farther_gradient_);
}

void Lbfgs::move_free(double length, const Positions& from, Positions& to, int threads,
                      const Execution& execution) const {
    parallel_for(static_cast<Index>(unknowns_->free.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index v = unknowns_->free[k];
            to.row(v) = from.row(v) + length * direction_.row(k);
        }
    });
}

}  // namespace meanvalue
