// Gauss-Seidel sweeps towards equation 17: the paper's last stage (section 3.2.2).
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// Visits the free vertices one by one and moves each to where equation 16, linearized in it alone, is zero:
/// v_i -= D_i^-1 dG/dv_i, D_i = sum_j B_ji^T B_ji over the rows j that contain v_i.
///
/// The print's own form, v_i = F_i + ..., is this one with D_i = I; it diverges where D_i has an eigenvalue above 2,
/// which noisy meshes have. Vertices are visited in their order, on one thread.
class GaussSeidel {
  public:
    /// @pre both outlive it. @throws Cancelled.
    /// Cost: for each row the square of its length, since each free vertex of a ring visits all of it.
    GaussSeidel(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution);

    /// One sweep over all free vertices. @param positions n x 3, changed in place. @throws Cancelled.
    /// Cost: for each row the square of its length: whatever moves in a ring changes its normal, and with it every
    /// term.
    void sweep(Positions& positions, const Execution& execution) const;

  private:
    struct Use {
        Index row;    // a vertex whose ring contains the free vertex
        Index place;  // where in that ring
    };
    void relax(Index number, Positions& positions) const;

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    Grouped<Use> uses_;  // of each free vertex
};

}  // namespace meanvalue
