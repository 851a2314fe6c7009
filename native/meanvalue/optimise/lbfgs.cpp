#include "meanvalue/optimise/lbfgs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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

/// sum_k a[k] b[k] in double precision, four sums side by side for the processor's vectors.
template <typename Number>
double dot(const float* a, const Number* b, std::int64_t count) {
    double sums[4] = {};
    for (std::int64_t k = 0; k + 4 <= count; k += 4) {
        for (std::int64_t lane = 0; lane < 4; ++lane)
            sums[lane] += static_cast<double>(a[k + lane]) * static_cast<double>(b[k + lane]);
    }
    for (std::int64_t k = count / 4 * 4; k < count; ++k)
        sums[0] += static_cast<double>(a[k]) * static_cast<double>(b[k]);
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// Adds factor * other to a vector, then multiplies it with `by`, where there are any: in one go through memory.
double add_and_multiply(Positions& vector, double factor, const std::vector<float>* other,
                        const std::vector<float>* by, int threads, const Execution& execution) {
    const auto rows = static_cast<Index>(vector.rows());
    const Index pieces = piece_count(rows);
    const int workers = std::clamp(pieces / 4, 1, threads);  // a thread is worth its waking for some pieces
    std::vector<double> sums(pieces, 0.0);
    parallel_pieces(rows, workers, execution, [&](Index piece, Index begin, Index end) {
        const std::int64_t first = std::int64_t{3} * begin;
        const std::int64_t count = std::int64_t{3} * (end - begin);
        double* const numbers = vector.data() + first;
        for (std::int64_t k = 0; other != nullptr && k < count; ++k)
            numbers[k] += factor * static_cast<double>((*other)[first + k]);
        if (by != nullptr) sums[piece] = dot(by->data() + first, numbers, count);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
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

void LbfgsHistory::find_direction(const Positions& gradient, const Preconditioner& preconditioner, int threads,
                                  const Execution& execution, Positions& direction) const {
    direction = -gradient;
    double factor = 0.0;
    const std::vector<float>* other = nullptr;  // to be added before the next product
    const auto multiply = [&](const std::vector<float>* by) {
        return add_and_multiply(direction, factor, std::exchange(other, nullptr), by, threads, execution);
    };
    std::vector<double> shares(pairs_.size());
    for (std::size_t k = pairs_.size(); k-- > 0;) {
        shares[k] = multiply(&pairs_[k].step) / pairs_[k].curvature;
        factor = -shares[k];
        other = &pairs_[k].change;
    }
    multiply(nullptr);
    preconditioner.solve(direction, direction, threads, execution);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        factor = shares[k] - multiply(&pairs_[k].change) / pairs_[k].curvature;
        other = &pairs_[k].step;
    }
    multiply(nullptr);
}

void LbfgsHistory::remember(double length, const Positions& direction, const Positions& gradient,
                            const Positions& next, int threads, const Execution& execution) {
    const auto numbers = static_cast<std::size_t>(rows_) * 3;
    next_.step.resize(numbers);
    next_.change.resize(numbers);
    std::vector<Vector3> sums(piece_count(rows_));  // of squared steps, products of both, and squared changes
    parallel_pieces(rows_, threads, execution, [&](Index piece, Index begin, Index end) {
        const std::int64_t first = std::int64_t{3} * begin;
        const std::int64_t count = std::int64_t{3} * (end - begin);
        float* const step = next_.step.data() + first;
        float* const change = next_.change.data() + first;
        for (std::int64_t n = 0; n < count; ++n) {
            step[n] = static_cast<float>(length * direction.data()[first + n] / size_);
            change[n] = static_cast<float>((next.data()[first + n] - gradient.data()[first + n]) / size_);
        }
        sums[piece] = {dot(step, step, count), dot(step, change, count), dot(change, change, count)};
    });
    const Vector3 total = std::accumulate(sums.begin(), sums.end(), Vector3(Vector3::Zero()));
    next_.curvature = total[1];
    // Where the energy curves upwards by more than rounding; written so that what is not a number is not kept.
    if (!(next_.curvature > kSinglePrecision * std::sqrt(total[0] * total[2]))) return;
    if (pairs_.size() < kPairs) {
        pairs_.push_back(std::move(next_));
        next_ = Pair();
    } else {
        std::swap(pairs_.front(), next_);
        std::rotate(pairs_.begin(), pairs_.begin() + 1, pairs_.end());
    }
}

}  // namespace meanvalue
