// The paper's hierarchical decoding, section 3.2, with another solver at its coarse level; and equation 15 to
// convergence at full resolution, section 2.3.
#pragma once

#include <algorithm>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/decoder.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/unknowns.h"
#include "meanvalue/paper/levenberg_marquardt.h"

namespace meanvalue {

/// Anchors placed; splits by equation 13; Gauss-Newton on the level with 3 % of the free vertices; the remaining
/// splits; four Gauss-Seidel sweeps. Steps on that level are damped and solved by a Cholesky factor, where the paper
/// has conjugate gradients and a bisection of each step (section 3.2.2). Deterministic for any number of threads.
class PaperDecoder : public Decoder {
  public:
    /// Builds the hierarchy. @throws Cancelled, SolverFailure.
    PaperDecoder(EncodedRegion shape, int threads, Execution& execution);

    /// The free vertices' positions are read only where no legal collapse could remove them; options but for those do
    /// not matter. Report: energies of the rest pose with the anchors in place and of the result; iterations and
    /// gradients of the coarse level; converged where both the base mesh and the coarse level did.
    /// @throws also SolverFailure where the energy of the start or the result is not finite.
    DecodeReport decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                        Execution& execution) const override;
    std::unique_ptr<Workspace> make_workspace(const Execution& /*execution*/) const override {
        return std::make_unique<Workspace>();
    }
    Index row_count() const override { return static_cast<Index>(fine_.rows.size()); }
    std::size_t bytes() const override;
    std::vector<Index> level_sizes() const override;
    Index longest_ring() const override { return std::max(encoding_.longest_ring(), hierarchy_.longest_ring()); }

  private:
    /// The unknowns of one level: removable vertices still there.
    Unknowns unknowns_of(const Level& level) const;
    DecodeReport solve_base(int threads, Positions& positions, Execution& execution) const;
    DecodeReport solve_coarse(double tolerance, int threads, Positions& positions, Execution& execution) const;

    double diagonal_;
    Unknowns fine_;
    Hierarchy hierarchy_;
    std::vector<Encoding> splits_;  // of each of its levels
    Unknowns coarse_unknowns_;
    Unknowns base_unknowns_;
};

/// Damped Gauss-Newton steps by sparse Cholesky from the better of two starts; the energy never rises.
class FullDecoder : public Decoder {
  public:
    /// @throws Cancelled, SolverFailure.
    FullDecoder(EncodedRegion shape, int threads, Execution& execution);

    std::unique_ptr<Workspace> make_workspace(const Execution& /*execution*/) const override {
        return std::make_unique<Workspace>();
    }
    DecodeReport decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                        Execution& execution) const override;
    Index row_count() const override { return static_cast<Index>(unknowns_.rows.size()); }
    std::size_t bytes() const override;
    std::vector<Index> level_sizes() const override { return {static_cast<Index>(unknowns_.free.size())}; }
    Index longest_ring() const override { return encoding_.longest_ring(); }

  private:
    double diagonal_;
    Unknowns unknowns_;
    SparseCholesky analysed_;
};

}  // namespace meanvalue
