// Laplacian coordinates: Alexa, "Differential coordinates for local mesh morphing and deformation", 2003.
#pragma once

#include "reference/problem.h"

namespace meanvalue::baselines {

/// Keeps the uniform Laplacian coordinates delta_i = v_i - (1/m_i) sum_j v_j of the rest shape as vectors, in the
/// least-squares sense. Exact under translation of all anchors; details are not turned with the shape.
/// @return n x 3. @throws InvalidInput, SolverFailure, Cancelled. Cost: one scalar factorization.
Positions laplacian(const Problem& problem, Execution& execution);

/// Where other methods start: setup.carried, with the rest of the way to the anchors spread smoothly, by keeping
/// its Laplacian coordinates. Met exactly by a similarity of all anchors.
/// @return n x 3, what is not solved for exactly at its place.
Positions smooth_start(const Setup& setup, const Execution& execution);

}  // namespace meanvalue::baselines
