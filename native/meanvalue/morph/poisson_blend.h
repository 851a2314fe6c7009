// The shape whose edges are nearest to those of cells that were turned: one linear solve.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/fast/rest_cells.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/supernodal_factor.h"

namespace meanvalue {

/// Minimises sum_i sum_k c_ik |(v_i - v_k) - R_i e_ik|^2 over all vertices, with weights c of some average of the
/// shapes (cotangents; Sorkine and Alexa 2007), so that its matrix is factored once: Poisson's equation for given
/// rotations and lengths (Yu et al. 2004; Xu et al. 2005). Each part of the mesh keeps its first vertex in place.
class PoissonBlend {
  public:
    /// @param layout the rings, n. @param cells of that average. @param pinned one vertex of each part.
    /// @pre layout outlives it. @throws Cancelled, SolverFailure.
    PoissonBlend(const Encoding& layout, const RestCells& cells, const std::vector<Index>& pinned,
                 InstructionSet instructions, int threads, const Execution& execution);

    struct Workspace {
        SupernodalFactor::Workspace factor;
        std::vector<Vector3> missing;  // for each half-edge
        Positions sums;
    };

    /// @param cells the e_ik; @param rotations the R_i, n; @param positions n x 3, any start near it; receives the
    /// result. Vertices without an edge stay. The same bits for any `threads`. @throws Cancelled.
    void solve(const RestCells& cells, const std::vector<Matrix3>& rotations, int threads, const Execution& execution,
               Workspace& workspace, Positions& positions) const;

    std::size_t bytes() const;

  private:
    void measure_weights(const RestCells& cells, const Execution& execution);
    void index_uses(const Execution& execution);
    SparseMatrix matrix(const std::vector<Index>& pinned) const;

    const Encoding& layout_;
    std::vector<double> weights_;   // c_ik for each half-edge
    std::vector<Index> use_start_;  // n + 1: where the half-edges that lead to a vertex are in uses_
    std::vector<Index> uses_;
    SupernodalFactor factor_;
};

}  // namespace meanvalue
