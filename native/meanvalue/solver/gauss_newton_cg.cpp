#include "meanvalue/solver/gauss_newton_cg.h"

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>

#include "meanvalue/solver/free_moves.h"

namespace meanvalue {
namespace {

constexpr int kMostSteps = 30;
constexpr double kSettledDecrease = 1e-6;
constexpr int kMostBisections = 20;
// H is singular where anchors leave something open; far below the smallest eigenvalue of a determined system.
constexpr double kLeastDiagonal = 1e-12;
// Shares of the right-hand side left by the conjugate gradients; rounds between looks at the cancel flag.
constexpr double kCgTolerance = 1e-4;
constexpr int kCgRoundsPerCheck = 64;
constexpr int kMostCgChunks = 64;

/// Solves H direction = -J as far as kCgTolerance.
void solve_by_cg(const SparseMatrix& lower, const Eigen::VectorXd& gradient, const Execution& execution,
                 Eigen::VectorXd& direction) {
    Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower> solver(lower);
    solver.setTolerance(kCgTolerance);
    solver.setMaxIterations(kCgRoundsPerCheck);
    direction = Eigen::VectorXd::Zero(gradient.size());
    for (int chunk = 0; chunk < kMostCgChunks; ++chunk) {
        execution.check();
        direction = solver.solveWithGuess(-gradient, direction);
        if (solver.error() <= kCgTolerance) break;
    }
}

}  // namespace

GaussNewtonCgReport minimise_by_cg(GaussNewtonSystem& system, const Unknowns& unknowns, int threads,
                                   Positions& positions, Execution& execution) {
    GaussNewtonCgReport report;
    double energy = system.energy(positions, threads, execution);
    report.energies.push_back(energy);
    Positions trial = positions;
    Eigen::VectorXd direction;
    for (int step = 0;; ++step) {
        if (step == kMostSteps) {
            report.converged = false;
            break;
        }
        execution.set_progress(static_cast<double>(step) / kMostSteps);
        system.linearise(positions, nullptr, threads, execution);
        if (system.gradient().squaredNorm() == 0.0) break;
        system.matrix().add_to_diagonal(kLeastDiagonal);
        solve_by_cg(system.matrix().matrix(), system.gradient(), execution, direction);

        double length = 1.0;
        double trial_energy = energy;
        for (int bisection = 0; bisection <= kMostBisections; ++bisection, length *= 0.5) {
            move_free(unknowns, positions, direction, length, trial);
            trial_energy = system.energy(trial, threads, execution);
            if (trial_energy < energy) break;
        }
        if (!(trial_energy < energy)) break;
        std::swap(positions, trial);
        ++report.iterations;
        report.energies.push_back(trial_energy);
        const double decrease = energy - trial_energy;
        energy = trial_energy;
        if (decrease < kSettledDecrease * energy) break;
    }
    return report;
}

}  // namespace meanvalue
