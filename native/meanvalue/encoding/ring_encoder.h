// The encoding of one vertex by one ring: paper, equations 1 to 9, and the rules for where they break down.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/mean_value_weights.h"

namespace meanvalue {

/// Encodes one vertex after another and holds the result of the last. One instance for each thread: it keeps
/// scratch memory.
class RingEncoder {
  public:
    /// @param positions n x 3; must outlive the encoder.
    explicit RingEncoder(const PositionsView& positions) : positions_(positions) {}

    /// @param ring spans a plane (spans_a_plane()).
    /// @return GuardReason flags; where kNotPredictable is among them, the coefficients mean nothing.
    std::uint8_t encode(Index vertex, const Index* ring, Index valence);

    const std::vector<double>& weights() const { return weights_; }        ///< w_ij
    const std::vector<double>& cotangents() const { return cotangents_; }  ///< b_ij
    const std::vector<double>& heights() const { return heights_; }        ///< see Encoding::heights
    double softening() const { return softening_; }                        ///< see SoftNormal
    /// u_ij, for a vertex flagged kSteepEdge.
    std::vector<double> steep_weights() const;

  private:
    void project(Index vertex, const Index* ring, Index valence);
    double tangential_error() const;
    bool needs_own_normal_weights(std::uint8_t flags) const;
    void fill_heights(std::uint8_t flags);

    const PositionsView& positions_;
    ProjectedRing projected_;
    double radius_sum_ = 0.0;
    double softening_ = 0.0;
    std::vector<double> weights_;
    std::vector<double> cotangents_;
    std::vector<double> heights_;
};

}  // namespace meanvalue
