// Pyramid coordinates: Sheffer and Kraevoy, "Pyramid coordinates for morphing and deformation", 3DPVT 2004.
#pragma once

#include "reference/problem.h"

namespace meanvalue::baselines {

struct PyramidOptions {
    int sweeps = 300;  ///< over all free vertices; always as many, since there is no objective that could tell
};

/// Puts each free vertex, again and again, where its mean-value weights and its heights over its ring say, in the
/// plane across the mean normal of its incident faces. That normal depends on the vertex itself, so that the decoding
/// is implicit; there is no objective, and anchors have no say but through their neighbors.
///
/// A reconstruction from the abstract and from what the mean-value paper says of it, not the authors' program: the
/// hierarchy of method "paper", decoded by splits, then damped Jacobi sweeps (share 0.7). More sweeps follow the
/// method's own fixed point more closely, which is not always a better shape. Exact under a similarity of all
/// anchors, to 1e-9 of the diagonal.
/// @return n x 3. @throws InvalidInput, Cancelled. Cost: building the hierarchy, and the sweeps.
Positions pyramid(const Problem& problem, const PyramidOptions& options, Execution& execution);

}  // namespace meanvalue::baselines
