// The paper's own minimiser: Gauss-Newton steps by conjugate gradients with bisection line search (section 3.2.2).
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/sparse_cholesky.h"
#include "meanvalue/optimise/gauss_newton_system.h"
#include "meanvalue/optimise/levenberg_marquardt.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The minimiser bound to one system: the preconditioner of its conjugate gradients, (I - W)^T (I - W), depends on
/// the rest pose only and is factored once. With it the rounds do not grow with the number of vertices.
class GaussNewtonCg {
  public:
    /// @pre system and unknowns outlive it. @throws Cancelled, SolverFailure.
    GaussNewtonCg(const GaussNewtonSystem& system, const Unknowns& unknowns, Execution& execution,
                  InstructionSet instructions = InstructionSet::kFastest);

    /// Moves the free vertices in `positions` towards a minimum of G: equations 16 to 19, with the exact derivative.
    /// Ends when the energy falls by less than 1e-4 of itself, when no step lowers it, or after 30 steps.
    /// @param negligible_energy an energy not above it is rounding, and there is nothing to do.
    /// @param positions n x 3; left in any state on an exception. @throws Cancelled.
    MinimiseReport minimise(double negligible_energy, int threads, Positions& positions, Execution& execution,
                            GaussNewtonSystem::Workspace& workspace) const;

  private:
    Eigen::VectorXd solve_step(const GaussNewtonSystem::Workspace& at, const Execution& execution) const;
    Eigen::VectorXd precondition(const Eigen::VectorXd& residual, const Execution& execution) const;

    const GaussNewtonSystem& system_;
    const Unknowns& unknowns_;
    SparseCholesky preconditioner_;
};

}  // namespace meanvalue
