// Minimizes equation 15 to convergence by damped Gauss-Newton steps: paper, section 2.3.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/decoder.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The decrease that settles a solve, in tolerances of positions: their errors go with the root of the energy's.
constexpr double kSettledPerTolerance = 100.0;

struct MinimiseOptions {
    double step_tolerance = 0.0;    ///< stop when no vertex would move farther than this (units of the input)
    double settled_decrease = 0.0;  ///< ... or when the energy falls by less than this share in three steps on end
    /// An energy not above this is rounding, or all that is asked for: there is nothing to do.
    double negligible_energy = 0.0;
    int max_iterations = 100;
    int threads = 1;
};

/// Moves the free vertices in `positions` to a minimum of G near where they are; the fixed ones keep their place.
/// @param cholesky analyzed for matrices of linearise(); analyzed here where it is not.
/// @param positions n x 3, finite. Left in any state on an exception.
/// @return `converged` where a minimum is near. @throws Cancelled, SolverFailure.
DecodeReport minimise(const Encoding& encoding, const Unknowns& unknowns, SparseCholesky& cholesky,
                      const MinimiseOptions& options, Positions& positions, Execution& execution);

/// One Gauss-Newton step away from `base` that moves the fixed vertices by `fixed_moves` at the same time, so that
/// the free ones follow smoothly instead of being left behind.
/// @param base n x 3; @param fixed_moves n x 3, zero in the rows of free vertices.
/// @return n x 3, fixed vertices at base + fixed_moves. @throws Cancelled, SolverFailure.
Positions follow_fixed_moves(const Encoding& encoding, const Unknowns& unknowns, SparseCholesky& cholesky,
                             const MinimiseOptions& options, const Positions& base, const Positions& fixed_moves,
                             Execution& execution);

}  // namespace meanvalue
