// As-rigid-as-possible surface modeling, spokes: Sorkine and Alexa, SGP 2007.
#pragma once

#include <vector>

#include "reference/problem.h"

namespace meanvalue::baselines {

struct ArapOptions {
    int iterations = 100;  ///< at most
    /// Stop when no vertex moves farther than this share of the rest shape's bounding-box diagonal.
    double tolerance = 1e-6;
};

/// Minimizes sum_i sum_j w_ij |(v'_i - v'_j) - R_i (v_i - v_j)|^2 by fitting rotations and placing vertices in turns,
/// from smooth_start(), with one prefactored Laplacian. Cotangent weights, kept positive.
/// @param energies where given, receives the sum, over stars with a free vertex, at the start and after each
///        iteration; it never rises.
/// @return n x 3. @throws InvalidInput, SolverFailure, Cancelled. Cost: two scalar factorizations and the iterations.
Positions arap(const Problem& problem, const ArapOptions& options, Execution& execution,
               std::vector<double>* energies = nullptr);

}  // namespace meanvalue::baselines
