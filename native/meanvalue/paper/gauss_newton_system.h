// The linear system of one Gauss-Newton step: paper, equations 16 to 19; and the paper's own way to relax it.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// Over the free vertices, three numbers for each of unknowns.free.
struct GaussNewtonSystem {
    SparseMatrix matrix;  ///< H = (I - dF)^T (I - dF), the lower triangle; its pattern does not depend on positions
    Eigen::VectorXd gradient;  ///< J = (I - dF)^T (V - F)
};

/// @throws Cancelled.
GaussNewtonSystem linearise(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& positions,
                            const Execution& execution);

/// (I - W)^T (I - W): the part of H that does not depend on the pose, in the pattern of H. It measures how unsmooth a
/// displacement is. @throws Cancelled.
SparseMatrix smoothness_metric(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution);

/// G of the rows that depend on free vertices (equation 15); the others cannot change. @throws Cancelled.
double energy(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& positions, int threads,
              const Execution& execution);

/// Gauss-Seidel sweeps: the paper's last stage (section 3.2.2). Visits the free vertices one by one, in their order,
/// and moves each to where equation 16, linearized in it alone, is zero:
/// v_i -= D_i^-1 dG/dv_i, D_i = sum_j B_ji^T B_ji over the rows j that contain v_i.
///
/// The print's own form, v_i = F_i + ..., is this one with D_i = I; it diverges where D_i has an eigenvalue above 2,
/// which noisy meshes have.
/// @param positions n x 3, changed in place. @throws Cancelled.
/// Cost: for each row the square of its length: whatever moves in a ring changes its normal, and with it every term.
void relax(const Encoding& encoding, const Unknowns& unknowns, int sweeps, Positions& positions,
           const Execution& execution);

}  // namespace meanvalue
