#include "meanvalue/solver/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// Damping is added to the diagonal of H, which has no units and entries near 1.
// The least of it keeps H factorable where a part has too few anchors: along the directions left open the gradient
// is zero, so that the answer stays nearest to the start there. It is far below the smallest eigenvalue of a
// determined system (about 1e-9 at 50,000 free vertices), so that it slows nothing.
constexpr double kLeastDamping = 1e-12;
constexpr double kFirstDamping = 1e-6;
constexpr double kDampingFactor = 10.0;
constexpr double kMostDamping = 1e6;
// A step must lower the energy by this share of what its slope promises (Armijo).
constexpr double kSufficientDecrease = 1e-4;
constexpr int kMostHalvings = 12;

/// One descent from a start; holds what its steps share.
class Descent {
  public:
    Descent(GaussNewtonSystem& system, SparseCholesky& cholesky, const Unknowns& unknowns,
            const MinimiseOptions& options, Positions& positions, Execution& execution)
        : system_(system),
          cholesky_(cholesky),
          unknowns_(unknowns),
          options_(options),
          positions_(positions),
          trial_(positions),
          execution_(execution) {}

    MinimiseReport run() {
        energy_ = evaluate(positions_);
        report_.energies.push_back(energy_);
        if (!std::isfinite(energy_)) throw SolverFailure("the energy of the start is not finite");
        report_.stop_reason = StopReason::kIterationLimit;
        for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
            execution_.set_progress(static_cast<double>(iteration) / options_.max_iterations);
            if (!step()) break;
        }
        return std::move(report_);
    }

  private:
    double evaluate(const Positions& positions) {
        const StageTimer timer(report_.timings, "energy");
        return system_.energy(positions, options_.threads, execution_);
    }

    /// One accepted step. @return whether another one is wanted.
    bool step() {
        linearise();
        if (report_.gradient == 0.0) return stop(StopReason::kConverged);
        for (; damping_ <= kMostDamping; raise_damping()) {
            if (!find_direction()) continue;
            const bool short_step =
                longest_move() <= options_.step_tolerance && damping_ <= kFirstDamping;
            const double length = search_line(short_step ? 0 : kMostHalvings);
            if (length > 0.0) {
                ++report_.iterations;
                report_.energies.push_back(energy_);
                if (length == 1.0) lower_damping();
            }
            if (short_step) return stop(StopReason::kConverged);
            if (length > 0.0) return true;
        }
        return stop(StopReason::kNoDescent);
    }

    bool stop(StopReason reason) {
        report_.stop_reason = reason;
        return false;
    }

    void linearise() {
        const StageTimer timer(report_.timings, "linearise");
        system_.linearise(positions_, options_.threads, execution_);
        report_.gradient = system_.gradient().norm();
        if (report_.iterations == 0) report_.initial_gradient = report_.gradient;
        applied_damping_ = 0.0;
    }

    /// Solves (H + damping) direction = -J, equation 19.
    bool find_direction() {
        const StageTimer timer(report_.timings, "factor");
        const double wanted = std::max(damping_, kLeastDamping);
        system_.matrix().add_to_diagonal(wanted - applied_damping_);
        applied_damping_ = wanted;
        if (!cholesky_.analysed()) cholesky_.analyse(system_.matrix().matrix(), execution_);
        if (!cholesky_.factorise(system_.matrix().matrix(), execution_)) return false;
        direction_ = -cholesky_.solve(system_.gradient());
        return direction_.allFinite();
    }

    double longest_move() const {
        double longest = 0.0;
        for (std::size_t k = 0; k < unknowns_.free.size(); ++k) {
            longest = std::max(longest, direction_.segment<3>(3 * static_cast<Eigen::Index>(k)).norm());
        }
        return longest;
    }

    /// Halves the step until the energy falls enough. @return the share of it taken, 0 where none was.
    double search_line(int most_halvings) {
        const double slope = direction_.dot(system_.gradient());
        double length = 1.0;
        for (int halving = 0; halving <= most_halvings; ++halving, length *= 0.5) {
            for (std::size_t k = 0; k < unknowns_.free.size(); ++k) {
                const Index v = unknowns_.free[k];
                const auto move = direction_.segment<3>(3 * static_cast<Eigen::Index>(k));
                trial_.row(v) = positions_.row(v) + length * move.transpose();
            }
            const double trial_energy = evaluate(trial_);
            // Written so that an energy that is not a number is refused.
            if (trial_energy < energy_ && trial_energy <= energy_ + kSufficientDecrease * length * slope) {
                energy_ = trial_energy;
                std::swap(positions_, trial_);
                return length;
            }
        }
        return 0.0;
    }

    void raise_damping() { damping_ = std::max(kFirstDamping, damping_ * kDampingFactor); }
    void lower_damping() {
        damping_ /= kDampingFactor;
        if (damping_ < kFirstDamping) damping_ = 0.0;
    }

    GaussNewtonSystem& system_;
    SparseCholesky& cholesky_;
    const Unknowns& unknowns_;
    const MinimiseOptions& options_;
    Positions& positions_;
    Positions trial_;  // equal to positions_ in every fixed row
    Execution& execution_;
    MinimiseReport report_;
    Eigen::VectorXd direction_;
    double energy_ = 0.0;
    double damping_ = 0.0;
    double applied_damping_ = 0.0;  // what is in the matrix' diagonal
};

}  // namespace

const char* describe(StopReason reason) {
    switch (reason) {
        case StopReason::kConverged: return "converged";
        case StopReason::kNothingToSolve: return "no free vertices";
        case StopReason::kNoDescent: return "no step lowers the energy further";
        case StopReason::kIterationLimit: return "iteration limit";
    }
    return "";
}

MinimiseReport minimise(GaussNewtonSystem& system, SparseCholesky& cholesky, const Unknowns& unknowns,
                        const MinimiseOptions& options, Positions& positions, Execution& execution) {
    execution.begin_stage("solve");
    if (unknowns.free.empty()) return {};
    return Descent(system, cholesky, unknowns, options, positions, execution).run();
}

}  // namespace meanvalue
