#include "meanvalue/optimise/lbfgs.h"

#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

constexpr int kMostHalvings = 20;
// A step at whose end the slope is more than this share of that at its start is lengthened, so many times at most.
// One of an inherited history that has to be shortened more often than so many times ends that.
constexpr double kSteep = 0.3;
constexpr double kLongest = 4.0;
// Steps this short in a row are the end; a single one may be a bad step.
constexpr int kShortSteps = 2;
// With an energy tolerance: the iterations that it is about, and how short the last has to be, in step tolerances.
// With patience, what comes after a single step that is as many times shorter than one does not matter even where the
// energy falls: there is little of it, and the next solve goes on. Half of a smooth drag's iterations.
constexpr int kSlowSteps = 4;
constexpr double kNearlyShort = 4.0;

/// Whether the last `steps` iterations together lowered the energy by more than `share` of it.
bool falls(const std::vector<double>& energies, std::size_t steps, double share) {
    return energies.size() <= steps || energies.back() < (1.0 - share) * energies[energies.size() - 1 - steps];
}

}  // namespace

Lbfgs::Lbfgs(const Unknowns& unknowns, double size) : unknowns_(&unknowns), size_(size) {
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
    while (gradient_.squaredNorm() > 0.0 && value > options.enough_energy) {
        if (report.iterations() == options.max_iterations) {
            report.at_limit = true;
            break;
        }
        execution.check();
        execution.set_progress(static_cast<double>(report.iterations()) / options.max_iterations);
        history_.find_direction(gradient_, preconditioner, options.threads, execution, direction_);
        const double slope = (direction_.cwiseProduct(gradient_)).sum();
        const double longest = std::sqrt(direction_.rowwise().squaredNorm().maxCoeff());
        report.converged = longest < kRounding * size_;  // the rest cannot be told from rounding
        if (report.converged) break;
        double length = slope < 0.0 ? 1.0 : 0.0;
        double trial_value = value;
        for (int halving = 0; length > 0.0; ++halving, length = halving > kMostHalvings ? 0.0 : 0.5 * length) {
            move_free(length, positions, trial_, options.threads, execution);
            trial_value = energy(trial_, trial_gradient_);
            if (falls_enough(value, trial_value, length * slope)) break;
            if (trial_ == positions) length = 0.0;  // as no shorter one moves anything
        }
        is_inherited = is_inherited && report.iterations() < LbfgsHistory::kPairs;
        if (length * kLongest < 1.0 && is_inherited) {
            // The history of another solve misleads here.
            history_.clear();
            is_inherited = false;
            continue;
        }
        if (length == 0.0) {
            if (history_.empty()) {
                // At the minimum but for rounding, or stuck.
                report.converged = longest < options.step_tolerance;
                break;
            }
            history_.clear();  // it may be misleading: once more without it
            continue;
        }
        // Not with patience: a drag's next frames make up for it, and each costs an evaluation.
        if (length == 1.0 && options.patience == 0)
            lengthen(energy, options.threads, value, slope, positions, execution, length, trial_value);
        history_.remember(length, direction_, gradient_, trial_gradient_, options.threads, execution);
        std::swap(positions, trial_);
        std::swap(gradient_, trial_gradient_);
        value = trial_value;
        report.energies.push_back(value);
        const double step = length * longest;
        short_steps = step < options.step_tolerance ? short_steps + 1 : 0;
        const auto falls_in = [&](int steps) { return falls(report.energies, steps, options.energy_tolerance); };
        const bool has_tolerance = options.energy_tolerance > 0.0;
        const bool is_short = short_steps >= kShortSteps && !(has_tolerance && falls_in(kShortSteps));
        const bool is_slow = has_tolerance && report.iterations() >= options.patience &&
                             step < kNearlyShort * options.step_tolerance && !falls_in(kSlowSteps);
        // The whole step: one that had to be shortened tells nothing.
        const bool is_out_of_sight = options.patience > 0 && kNearlyShort * longest < options.step_tolerance;
        if (is_short || is_slow || is_out_of_sight) {
            report.converged = true;
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
