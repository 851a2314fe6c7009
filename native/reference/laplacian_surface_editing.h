// Laplacian surface editing: Sorkine, Cohen-Or, Lipman, Alexa, Roessl, Seidel, SGP 2004.
#pragma once

#include "reference/problem.h"

namespace meanvalue::baselines {

struct LaplacianSurfaceEditingOptions {
    /// 1: the published linear method. More: after each solve the rest star of each vertex is turned by the rotation
    /// that carries it best to the shape found, and its similarity is linearized anew about that, so that what is
    /// left to linearize is small.
    int rounds = 1;
};

/// Keeps Laplacian coordinates up to a linearized similarity of each ring that is part of the unknowns.
/// Exact under translation and uniform scale of all anchors, to second order in the angle under rotation (one round).
/// @return n x 3. @throws InvalidInput, SolverFailure, Cancelled. Cost: one 3n factorization a round.
Positions laplacian_surface_editing(const Problem& problem, const LaplacianSurfaceEditingOptions& options,
                                    Execution& execution);

}  // namespace meanvalue::baselines
