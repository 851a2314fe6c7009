// The shape that agrees best with given cells and their rotations: one linear solve.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {

/// Factors the Laplacian of a graph. The first vertex of each part is held: this fixes where the part is, and nothing
/// else. @param entries minus the weight of each edge, below the diagonal. @throws Cancelled, SolverFailure.
void factor_laplacian(Index vertices, std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries,
                      int threads, const Execution& execution, SupernodalFactor& factor);

/// Minimizes, with e_ik = v_i - v_k of the result and t_ik = R_i times that of the cells, over all triangles (i, j,
/// k) seen from each of their corners
///     sum_i sum_(j,k) s_ik |e_ik - t_ik|^2 + c_jk |(e_ij - t_ij) - (e_ik - t_ik)|^2,
/// with cotangent weights of some average of the shapes, whose matrix is factored once.
/// Poisson's equation for given rotations and lengths (Yu et al. 2004; Xu et al. 2005). Where each part of the mesh
/// is stays open.
class CellAssembly {
  public:
    /// @param edges of all rings of the average. @pre rings outlive it. @throws Cancelled, SolverFailure.
    CellAssembly(const OneRings& rings, const std::vector<Vector3>& edges, InstructionSet instructions, int threads,
                 const Execution& execution);

    /// @param edges of all rings, each in its cell's own frame; @param rotations the R_i, n; @param positions n x 3,
    /// any start; receives the result. The same bits for any `threads`. @throws Cancelled.
    void solve(const std::vector<Vector3>& edges, const std::vector<Quaternion>& rotations, int threads,
               const Execution& execution, Positions& positions) const;

  private:
    void measure(const std::vector<Vector3>& edges, int threads, const Execution& execution);
    Vector3 pull_of(Index row, const std::vector<Vector3>& edges, const Matrix3& rotation, const Positions& positions,
                    std::vector<Vector3>& missing, Vector3* shares) const;

    const OneRings& rings_;
    std::vector<double> spokes_;  // |ring|: s_ik
    std::vector<double> rims_;    // |ring|: c_kl, l the next in the ring
    SupernodalFactor factor_;
};

}  // namespace meanvalue
