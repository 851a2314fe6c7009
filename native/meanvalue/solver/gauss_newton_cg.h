// The paper's own minimiser: Gauss-Newton steps by conjugate gradients with bisection line search (section 3.2.2).
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/solver/gauss_newton_system.h"
#include "meanvalue/solver/unknowns.h"

namespace meanvalue {

struct GaussNewtonCgReport {
    int iterations = 0;
    bool converged = true;         ///< ended before the limit of steps
    std::vector<double> energies;  ///< G at the start and after each iteration; never rises
};

/// Moves the free vertices in `positions` towards a minimum of G: equations 16 to 19, with the exact derivative.
/// Ends when the energy falls by less than 1e-6 of itself, when no step lowers it, or after 30 steps.
/// @param positions n x 3; left in any state on an exception. @throws Cancelled.
GaussNewtonCgReport minimise_by_cg(GaussNewtonSystem& system, const Unknowns& unknowns, int threads,
                                   Positions& positions, Execution& execution);

}  // namespace meanvalue
