#include "meanvalue/paper/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/optimise/line_search.h"

namespace meanvalue {
namespace {

// kRounding on the diagonal of H, which has no units and entries near 1, keeps H factorable where a part has too few
// anchors. Along the directions left open the gradient is zero, so that the answer stays nearest to the start there.
// It is far below the smallest eigenvalue of a determined system (about 1e-9 at 50,000 free vertices).
// Damping multiplies the smoothness metric (I - W)^T (I - W), not I: what spoils Gauss-Newton steps here are rings
// that fold where neighbors move apart, and the metric forbids just that (docs/decisions/0003-damping.md).
constexpr double kFirstDamping = 0.1;
constexpr double kLeastDamping = 1e-4;  // below it, none
constexpr double kDampingFactor = 3.0;
// Halving costs one energy, more damping a factorization; but a step that must be shorter than this points wrong.
constexpr int kMostHalvings = 3;
// Slow steps on end that tell a flat valley from a step that was merely bad.
constexpr int kSettledSteps = 3;

/// to = from + length * direction in the rows of free vertices.
void move_free(const Unknowns& unknowns, const Positions& from, const Eigen::VectorXd& direction, double length,
               Positions& to) {
    for (std::size_t k = 0; k < unknowns.free.size(); ++k) {
        const Index v = unknowns.free[k];
        to.row(v) = from.row(v) + length * direction.segment<3>(3 * static_cast<Eigen::Index>(k)).transpose();
    }
}

/// Solves H direction = -J (equation 19). @return whether H could be factored and the direction is finite.
bool solve_step(const GaussNewtonSystem::Workspace& at, SparseCholesky& cholesky, int threads,
                const Execution& execution, Eigen::VectorXd& direction) {
    if (!cholesky.analysed()) cholesky.analyse(at.matrix.matrix(), execution, threads);
    if (!cholesky.factorise(at.matrix.matrix(), execution, threads)) return false;
    direction = -cholesky.solve(at.gradient, execution);
    return direction.allFinite();
}

/// One descent from a start, with the state that its steps share.
class Descent {
  public:
    Descent(const GaussNewtonSystem& system, GaussNewtonSystem::Workspace& workspace, SparseCholesky& cholesky,
            const Unknowns& unknowns, const MinimiseOptions& options, Positions& positions, Execution& execution)
        : system_(system),
          workspace_(workspace),
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
        report_.stop_reason = StopReason::kConverged;
        if (energy_ <= options_.negligible_energy) return std::move(report_);
        report_.stop_reason = StopReason::kIterationLimit;
        for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
            execution_.set_progress(static_cast<double>(iteration) / options_.max_iterations);
            if (!step()) break;
            if (energy_ <= options_.negligible_energy) {
                stop(StopReason::kConverged);
                break;
            }
        }
        return std::move(report_);
    }

  private:
    double evaluate(const Positions& positions) {
        const StageTimer timer(report_.timings, "energy");
        return system_.energy(positions, options_.threads, execution_, workspace_);
    }

    /// One accepted step. @return whether another one is wanted.
    bool step() {
        linearise();
        if (report_.gradient == 0.0) return stop(StopReason::kConverged);
        for (; damping_ * kCoincident < 1.0; raise_damping()) {
            if (!find_direction()) continue;
            const bool short_step = longest_move() <= options_.step_tolerance;
            const double start_energy = energy_;
            const double length = search_line(short_step ? 0 : kMostHalvings);
            if (length > 0.0) {
                ++report_.iterations;
                report_.energies.push_back(energy_);
                report_.promised_share = applied_damping_ <= kFirstDamping
                                             ? promised_decrease_ / start_energy
                                             : std::numeric_limits<double>::infinity();  // damped: it says nothing
                if (length < 1.0) {
                    raise_damping();
                } else {
                    lower_damping();
                }
                settled_steps_ =
                    start_energy - energy_ < options_.settled_decrease * energy_ ? settled_steps_ + 1 : 0;
            }
            if (short_step) {
                return stop(applied_damping_ <= kFirstDamping ? StopReason::kConverged : StopReason::kNoDescent);
            }
            if (settled_steps_ >= kSettledSteps) return stop(StopReason::kSettled);
            if (length > 0.0) return true;
        }
        return stop(StopReason::kNoDescent);
    }

    void raise_damping() { damping_ = std::max(kLeastDamping, damping_ * kDampingFactor); }
    void lower_damping() { damping_ = damping_ > kLeastDamping ? damping_ / kDampingFactor : 0.0; }

    bool stop(StopReason reason) {
        report_.stop_reason = reason;
        return false;
    }

    void linearise() {
        const StageTimer timer(report_.timings, "linearise");
        system_.linearise(positions_, nullptr, options_.threads, execution_, workspace_);
        report_.gradient = workspace_.gradient.norm();
        if (report_.iterations == 0) report_.initial_gradient = report_.gradient;
        workspace_.matrix.add_to_diagonal(kRounding);
        applied_damping_ = 0.0;
    }

    /// Solves (H + damping * metric) direction = -J.
    bool find_direction() {
        const StageTimer timer(report_.timings, "factor");
        workspace_.matrix.add_identity_multiples(system_.smoothness_metric(), damping_ - applied_damping_);
        applied_damping_ = damping_;
        return solve_step(workspace_, cholesky_, options_.threads, execution_, direction_);
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
        const double slope = direction_.dot(workspace_.gradient);
        promised_decrease_ = -0.5 * slope;
        double length = 1.0;
        for (int halving = 0; halving <= most_halvings; ++halving, length *= 0.5) {
            move_free(unknowns_, positions_, direction_, length, trial_);
            const double trial_energy = evaluate(trial_);
            if (falls_enough(energy_, trial_energy, length * slope)) {
                energy_ = trial_energy;
                std::swap(positions_, trial_);
                return length;
            }
        }
        return 0.0;
    }

    const GaussNewtonSystem& system_;
    GaussNewtonSystem::Workspace& workspace_;
    SparseCholesky& cholesky_;
    const Unknowns& unknowns_;
    const MinimiseOptions& options_;
    Positions& positions_;
    Positions trial_;  // equal to positions_ in every fixed row
    Execution& execution_;
    MinimiseReport report_;
    Eigen::VectorXd direction_;
    double energy_ = 0.0;
    double promised_decrease_ = 0.0;
    double damping_ = kFirstDamping;
    double applied_damping_ = 0.0;  // what is in the matrix already
    int settled_steps_ = 0;
};

}  // namespace

const char* describe(StopReason reason) {
    switch (reason) {
        case StopReason::kConverged:
            return "converged";
        case StopReason::kSettled:
            return "the energy no longer falls";
        case StopReason::kNothingToSolve:
            return "no free vertices";
        case StopReason::kNoDescent:
            return "no step lowers the energy further";
        case StopReason::kIterationLimit:
            return "iteration limit";
    }
    return "";
}

MinimiseReport minimise(const GaussNewtonSystem& system, GaussNewtonSystem::Workspace& workspace,
                        SparseCholesky& cholesky, const Unknowns& unknowns, const MinimiseOptions& options,
                        Positions& positions, Execution& execution) {
    execution.begin_stage("solve");
    if (unknowns.free.empty()) return {};
    return Descent(system, workspace, cholesky, unknowns, options, positions, execution).run();
}

Positions follow_fixed_moves(const GaussNewtonSystem& system, GaussNewtonSystem::Workspace& workspace,
                             SparseCholesky& cholesky, const Unknowns& unknowns, const MinimiseOptions& options,
                             const Positions& base, const Positions& fixed_moves, Execution& execution) {
    system.linearise(base, &fixed_moves, options.threads, execution, workspace);
    workspace.matrix.add_to_diagonal(kRounding);
    Eigen::VectorXd direction;
    Positions result = base + fixed_moves;
    if (solve_step(workspace, cholesky, options.threads, execution, direction)) {
        move_free(unknowns, base, direction, 1.0, result);
    } else {
        for (const Index v : unknowns.free)
            result.row(v) = base.row(v);
    }
    return result;
}

}  // namespace meanvalue
