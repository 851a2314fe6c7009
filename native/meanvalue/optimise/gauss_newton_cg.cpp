#include "meanvalue/optimise/gauss_newton_cg.h"

#include "meanvalue/common/errors.h"
#include "meanvalue/optimise/free_moves.h"

namespace meanvalue {
namespace {

constexpr int kMostSteps = 30;
// The level is only a stage on the way; the splits that follow undo more than what is left by then.
constexpr double kSettledDecrease = 1e-4;
constexpr int kMostBisections = 20;
// The systems are singular where anchors leave something open; far below the smallest eigenvalue of a determined one.
constexpr double kLeastDiagonal = 1e-12;
// Share of the right-hand side left by the conjugate gradients, and the most rounds of them. Not less: what further
// rounds add are long moves along flat directions, for which the line search then shortens the whole step. With 1e-2
// the feline of Table 1 took 3.3 times as long for a higher energy.
constexpr double kCgTolerance = 0.1;
constexpr int kMostRounds = 500;

}  // namespace

GaussNewtonCg::GaussNewtonCg(const GaussNewtonSystem& system, const Unknowns& unknowns, Execution& execution,
                             InstructionSet instructions)
    : system_(system), unknowns_(unknowns), preconditioner_(instructions) {
    if (unknowns_.free.empty()) return;
    SparseMatrix metric = system_.pattern().with_numbers(system_.smoothness_metric());
    for (Eigen::Index k = 0; k < metric.cols(); ++k)
        metric.coeffRef(k, k) += kLeastDiagonal;
    preconditioner_.analyse(metric, execution);
    if (!preconditioner_.factorise(metric, execution)) {
        throw SolverFailure(message("the coarse level of ", unknowns_.free.size(), " free vertices is singular"));
    }
}

Eigen::VectorXd GaussNewtonCg::precondition(const Eigen::VectorXd& residual, const Execution& execution) const {
    using RowByVertex = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const RowByVertex solved =
        preconditioner_.solve(Eigen::Map<const RowByVertex>(residual.data(), residual.size() / 3, 3), execution);
    return Eigen::Map<const Eigen::VectorXd>(solved.data(), residual.size());
}

/// H direction = -J (equation 19), as far as kCgTolerance.
Eigen::VectorXd GaussNewtonCg::solve_step(const GaussNewtonSystem::Workspace& at, const Execution& execution) const {
    const auto matrix = at.matrix.matrix().selfadjointView<Eigen::Lower>();
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(at.gradient.size());
    Eigen::VectorXd residual = -at.gradient;
    Eigen::VectorXd preconditioned = precondition(residual, execution);
    Eigen::VectorXd search = preconditioned;
    double product = residual.dot(preconditioned);
    const double enough = kCgTolerance * kCgTolerance * product;

    for (int round = 0; round < kMostRounds && product > enough; ++round) {
        execution.check();
        const Eigen::VectorXd image = matrix * search;
        const double length = product / search.dot(image);
        direction += length * search;
        residual -= length * image;
        preconditioned = precondition(residual, execution);
        const double next_product = residual.dot(preconditioned);
        search = preconditioned + next_product / product * search;
        product = next_product;
    }
    return direction;
}

MinimiseReport GaussNewtonCg::minimise(double negligible_energy, int threads, Positions& positions,
                                       Execution& execution, GaussNewtonSystem::Workspace& workspace) const {
    MinimiseReport report;
    if (unknowns_.free.empty()) {
        report.energies.push_back(0.0);
        return report;
    }
    double energy = system_.energy(positions, threads, execution, workspace);
    report.energies.push_back(energy);
    report.stop_reason = StopReason::kConverged;
    if (energy <= negligible_energy) return report;
    report.stop_reason = StopReason::kIterationLimit;
    Positions trial = positions;
    for (int step = 0; step < kMostSteps; ++step) {
        execution.set_progress(static_cast<double>(step) / kMostSteps);
        system_.linearise(positions, nullptr, threads, execution, workspace);
        report.gradient = workspace.gradient.norm();
        if (step == 0) report.initial_gradient = report.gradient;
        if (report.gradient == 0.0) {
            report.stop_reason = StopReason::kConverged;
            break;
        }
        workspace.matrix.add_to_diagonal(kLeastDiagonal);
        const Eigen::VectorXd direction = solve_step(workspace, execution);
        report.promised_share = -0.5 * direction.dot(workspace.gradient) / energy;

        double length = 1.0;
        double trial_energy = energy;
        for (int bisection = 0; bisection <= kMostBisections; ++bisection, length *= 0.5) {
            move_free(unknowns_, positions, direction, length, trial);
            trial_energy = system_.energy(trial, threads, execution, workspace);
            if (trial_energy < energy) break;
        }
        if (!(trial_energy < energy)) {
            report.stop_reason = StopReason::kNoDescent;
            break;
        }
        std::swap(positions, trial);
        ++report.iterations;
        report.energies.push_back(trial_energy);
        const double decrease = energy - trial_energy;
        energy = trial_energy;
        if (decrease < kSettledDecrease * energy) {
            report.stop_reason = StopReason::kSettled;
            break;
        }
    }
    return report;
}

}  // namespace meanvalue
