#include "meanvalue/paper/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/optimise/lbfgs.h"
#include "meanvalue/paper/gauss_newton_system.h"

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
// Where a minimum is near: of the energy, what the linear model promises to the last step at most, and of the start's
// gradient what is left.
constexpr double kNearMinimum = 0.02;
constexpr double kVanishedGradient = 1e-3;
// Slow steps on end that tell a flat valley from a step that was merely bad.
constexpr int kSettledSteps = 3;

constexpr const char* kConverged = "converged";

/// to = from + length * direction in the rows of free vertices.
void move_free(const Unknowns& unknowns, const Positions& from, const Eigen::VectorXd& direction, double length,
               Positions& to) {
    const Eigen::Map<const Positions> moves(direction.data(), direction.size() / 3, 3);
    to(unknowns.free, Eigen::all) = from(unknowns.free, Eigen::all) + length * moves;
}

/// Solves matrix * direction = -gradient (equation 19). @return whether the matrix could be factored and the
/// direction is finite.
bool solve_step(SparseMatrix matrix, const Eigen::VectorXd& gradient, SparseCholesky& cholesky, int threads,
                const Execution& execution, Eigen::VectorXd& direction) {
    // A vertex in no row has no entry yet: diagonal() would write beside the values.
    SparseMatrix identity(matrix.rows(), matrix.cols());
    identity.setIdentity();
    matrix += kRounding * identity;
    if (!cholesky.analysed()) cholesky.analyse(matrix, execution, threads);
    if (!cholesky.factorise(matrix, execution, threads)) return false;
    direction = -cholesky.solve(gradient, execution);
    return direction.allFinite();
}

/// One descent from a start, with the state that its steps share.
class Descent {
  public:
    Descent(const Encoding& encoding, const Unknowns& unknowns, SparseCholesky& cholesky,
            const MinimiseOptions& options, Positions& positions, Execution& execution)
        : encoding_(encoding),
          unknowns_(unknowns),
          cholesky_(cholesky),
          options_(options),
          positions_(positions),
          trial_(positions),
          execution_(execution),
          metric_(smoothness_metric(encoding, unknowns, execution)) {}

    DecodeReport run() {
        energy_ = evaluate(positions_);
        report_.energies = {energy_};
        if (!std::isfinite(energy_)) throw SolverFailure("the energy of the start is not finite");
        for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
            execution_.set_progress(static_cast<double>(iteration) / options_.max_iterations);
            if (energy_ <= options_.negligible_energy) break;
            if (!step()) return std::move(report_);
        }
        const bool is_done = energy_ <= options_.negligible_energy;
        stop(is_done ? kConverged : "iteration limit", is_done);
        return std::move(report_);
    }

  private:
    double evaluate(const Positions& positions) {
        const StageTimer timer(report_.timings, "energy");
        return energy(encoding_, unknowns_, positions, options_.threads, execution_);
    }

    /// One accepted step. @return whether another one is wanted.
    bool step() {
        linearise_here();
        if (report_.gradient == 0.0) return stop(kConverged, true);
        for (; damping_ * kCoincident < 1.0; raise_damping()) {
            if (!find_direction()) continue;
            const bool short_step = longest_move() <= options_.step_tolerance;
            const double start_energy = energy_;
            const double length = search_line(short_step ? 0 : kMostHalvings);
            const bool damped = damping_ > kFirstDamping;
            if (length > 0.0) {
                ++report_.iterations;
                report_.energies.push_back(energy_);
                promises_little_ = !damped && promised_decrease_ <= kNearMinimum * start_energy;
                if (length < 1.0) {
                    raise_damping();
                } else {
                    lower_damping();
                }
                settled_steps_ =
                    start_energy - energy_ < options_.settled_decrease * energy_ ? settled_steps_ + 1 : 0;
            }
            if (short_step && !damped) return stop(kConverged, true);
            if (short_step) break;
            // Short steps fall slowly anywhere: a minimum is near where no more was to be expected.
            if (settled_steps_ >= kSettledSteps)
                return stop("the energy no longer falls", promises_little_ || has_vanished());
            if (length > 0.0) return true;
        }
        return stop("no step lowers the energy further", has_vanished());  // at the limit of rounding
    }

    /// Whether the gradient has.
    bool has_vanished() const { return report_.gradient <= kVanishedGradient * report_.initial_gradient; }

    void raise_damping() { damping_ = std::max(kLeastDamping, damping_ * kDampingFactor); }
    void lower_damping() { damping_ = damping_ > kLeastDamping ? damping_ / kDampingFactor : 0.0; }

    bool stop(const char* reason, bool converged) {
        report_.stop_reason = reason;
        report_.converged = converged;
        return false;
    }

    void linearise_here() {
        const StageTimer timer(report_.timings, "linearise");
        system_ = linearise(encoding_, unknowns_, positions_, execution_);
        report_.gradient = system_.gradient.norm();
        if (report_.iterations == 0) report_.initial_gradient = report_.gradient;
    }

    bool find_direction() {
        const StageTimer timer(report_.timings, "factor");
        return solve_step(system_.matrix + damping_ * metric_, system_.gradient, cholesky_, options_.threads,
                          execution_, direction_);
    }

    double longest_move() const {
        const Eigen::Map<const Positions> moves(direction_.data(), direction_.size() / 3, 3);
        return moves.rowwise().norm().maxCoeff();
    }

    /// Halves the step until the energy falls enough. @return the share of it taken, 0 where none was.
    double search_line(int most_halvings) {
        const double slope = direction_.dot(system_.gradient);
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

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    SparseCholesky& cholesky_;
    const MinimiseOptions& options_;
    Positions& positions_;
    Positions trial_;  // equal to positions_ in every fixed row
    Execution& execution_;
    SparseMatrix metric_;
    GaussNewtonSystem system_;  // at positions_
    DecodeReport report_;
    Eigen::VectorXd direction_;
    double energy_ = 0.0;
    double promised_decrease_ = 0.0;
    bool promises_little_ = false;  // the linear model, at the last step
    double damping_ = kFirstDamping;
    int settled_steps_ = 0;
};

}  // namespace

DecodeReport minimise(const Encoding& encoding, const Unknowns& unknowns, SparseCholesky& cholesky,
                      const MinimiseOptions& options, Positions& positions, Execution& execution) {
    execution.begin_stage("solve");
    if (!unknowns.free.empty()) return Descent(encoding, unknowns, cholesky, options, positions, execution).run();
    DecodeReport report;
    report.stop_reason = "no free vertices";
    return report;
}

void choose_start(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& rest,
                  const std::vector<char>& is_fixed, int threads, Positions& positions, const Execution& execution) {
    const Positions all_carried = carry_along(rest, positions, is_fixed);
    Positions carried = positions;
    for (const Index v : unknowns.free)
        carried.row(v) = all_carried.row(v);
    if (energy(encoding, unknowns, carried, threads, execution) <=
        energy(encoding, unknowns, positions, threads, execution)) {
        positions = std::move(carried);
    }
}

}  // namespace meanvalue
