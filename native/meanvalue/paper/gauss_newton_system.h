// The linear system of one Gauss-Newton step: paper, equations 16 to 19.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/optimise/unknowns.h"
#include "meanvalue/paper/block_matrix.h"

namespace meanvalue {

/// Assembles the gradient J = (I - dF)^T (V - F) and the Gauss-Newton matrix H = (I - dF)^T (I - dF) over the
/// free vertices. The pattern is found once; block column k belongs to unknowns.free[k]. Nothing here is written to
/// after that: what a linearization fills is a Workspace, one for each solve that runs.
class GaussNewtonSystem {
  public:
    struct Workspace {
        BlockMatrix matrix;
        Eigen::VectorXd gradient;  ///< 3 |V'|
        std::vector<Matrix3> term_blocks;
        std::vector<Vector3> residuals;  ///< |rows|
    };

    /// @pre both outlive the system, and no ring is too long (require_short_rings()). @throws Cancelled.
    GaussNewtonSystem(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution);

    /// @throws Cancelled.
    Workspace make_workspace(const Execution& execution) const;

    /// G of the rows that depend on free vertices (equation 15); the others cannot change.
    double energy(const PositionsView& positions, int threads, const Execution& execution,
                  Workspace& workspace) const;

    /// Computes gradient and matrix at `positions`.
    /// @param fixed_moves n x 3, or nullptr: where given, the step that they lead to belongs to fixed vertices that
    ///        move by those rows at the same time (rows of free vertices are not read).
    void linearise(const PositionsView& positions, const Positions* fixed_moves, int threads,
                   const Execution& execution, Workspace& workspace) const;

    /// Where matrices have blocks; its own numbers are not set.
    const BlockMatrix& pattern() const { return pattern_; }
    /// The blocks of (I - W)^T (I - W), each a multiple of I, for BlockMatrix::add_identity_multiples(): the part of
    /// H that does not depend on the pose. It measures how unsmooth a displacement is.
    const std::vector<double>& smoothness_metric() const { return smoothness_metric_; }

  private:
    void find_pattern(const Execution& execution);
    void fill_smoothness_metric(const Execution& execution);
    void assemble(const Execution& execution, Workspace& workspace) const;

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    BlockMatrix pattern_;
    // A row's terms: the columns it reaches (block column, dr_i/dv_k) and where the products of their pairs go.
    std::vector<std::int64_t> term_offsets_;  // |rows| + 1
    std::vector<Index> term_columns_;
    std::vector<std::int64_t> pair_offsets_;    // |rows| + 1
    std::vector<std::int64_t> pair_positions_;  // for every a, b of a row with column a >= column b
    std::vector<double> smoothness_metric_;
};

}  // namespace meanvalue
