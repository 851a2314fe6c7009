// The shape that turned cells make when they are put together: one linear solve.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/decode/fast/rest_cells.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {

/// Minimises, with e_ik = v_i - v_k of the result and t_ik = R_i times that of the cells,
///     sum_i a_i |sum_k w_ik (e_ik - t_ik)|^2 + sum_i sum_(j,k) c_jk |(e_ik - t_ik) - (e_ij - t_ij)|^2 and spokes,
/// which is DeformationEnergy with the rotations given, the first sum's normals among them, and with the weights of
/// some average of the shapes: its matrix is that energy's constant one, factored once. Poisson's equation for given
/// rotations and lengths (Yu et al. 2004; Xu et al. 2005) with the Laplacian's own differences beside the edges.
class CellAssembly {
  public:
    /// @param layout the rings, n. @param rows of the energy with all n vertices free.
    /// @pre all outlive it.
    CellAssembly(const Encoding& layout, QuadraticRows rows, const SupernodalFactor& factor,
                 const Execution& execution);

    struct Workspace {
        SupernodalFactor::Workspace factor;
        std::vector<Vector3> shares;  // for each half-edge, to the vertex that it leads to
        Positions sums;
    };

    /// @param cells with their edges; @param rotations the R_i, n; @param positions n x 3, any start; receives the
    /// result. The same bits for any `threads`. @throws Cancelled.
    void solve(const RestCells& cells, const std::vector<Quaternion>& rotations, int threads, const Execution& execution,
               Workspace& workspace, Positions& positions) const;

    std::size_t bytes() const;

  private:
    void index_uses(const Execution& execution);
    Vector3 pull_of(Index row, const RestCells& cells, const Matrix3& rotation, const Positions& positions,
                    std::vector<Vector3>& missing, Vector3* shares) const;

    const Encoding& layout_;
    QuadraticRows rows_;
    const SupernodalFactor& factor_;
    std::vector<Index> use_start_;  // n + 1: where the half-edges that lead to a vertex are in uses_
    std::vector<Index> uses_;
};

}  // namespace meanvalue
