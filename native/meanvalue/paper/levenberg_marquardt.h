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

/// Where minimise() is to begin: leaves the free vertices in `positions` where they are, or carries them along with
/// the fixed ones from rest, whichever has the lower energy. Where anchors leave something open, both may end at
/// energies that are zero but for rounding, and only one is near.
/// @param rest n x 3; @param is_fixed n flags of the vertices that tell where to; @param positions n x 3.
void choose_start(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& rest,
                  const std::vector<char>& is_fixed, int threads, Positions& positions, const Execution& execution);

}  // namespace meanvalue
