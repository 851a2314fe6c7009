// Equation 15 to convergence at full resolution: paper, section 2.3.
#pragma once

#include "meanvalue/decode/decoder.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/unknowns.h"
#include "meanvalue/paper/levenberg_marquardt.h"

namespace meanvalue {

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
