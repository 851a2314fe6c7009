// Linear rotation-invariant coordinates: Lipman, Sorkine, Levin and Cohen-Or, SIGGRAPH 2005.
#pragma once

#include "reference/problem.h"

namespace meanvalue::baselines {

/// Keeps each edge in the frames of its ends, and the differences of frames along edges, in two linear least squares
/// solves: first of the frames, then of the positions (docs/algorithm.md, "Baselines").
///
/// Only positions are given, and the method asks for frames where it is held. What is outside the region of influence
/// keeps its frame. That of an anchor is turned by the rotation that fits best to those of it and its ring that are
/// anchors; where these are on one line, as with a single anchor, to the whole ring in smooth_start().
/// Exact under rigid motion of all anchors.
/// @return n x 3. @throws InvalidInput, SolverFailure, Cancelled. Cost: two scalar factorizations.
Positions rotation_invariant(const Problem& problem, Execution& execution);

}  // namespace meanvalue::baselines
