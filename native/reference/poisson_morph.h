// Poisson shape interpolation: Xu, Zhang, Wang and Bao, ACM Symposium on Solid and Physical Modeling 2005.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue::baselines {

/// The shape between two others of one mesh. Each triangle's map from the first to the second, its normal with it, is
/// split into a rotation and a stretch (polar decomposition); the angle of the one and the entries of the other go
/// evenly, and Poisson's equation puts the triangles together (cotangent weights of the first shape). Turns are taken
/// the shorter way round. The first vertex of each part is where the linear blend has it.
/// @param first, second n x 3; @param share 0: the first, 1: the second.
/// @return n x 3. @throws InvalidInput, SolverFailure, Cancelled. Cost: one factorization.
Positions poisson_morph(const PositionsView& first, const PositionsView& second, const TrianglesView& faces,
                        double share, Execution& execution);

}  // namespace meanvalue::baselines
