// The encoding of one vertex by one ring: paper, equations 1 to 9, and the rules for where they break down.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// A ring as its vertex sees it: everything relative to the vertex, split along and across the normal.
struct ProjectedRing {
    Vector3 normal;                   ///< unit
    std::vector<Vector3> tangential;  ///< m: v'_j - v'_i, in the projection plane (equations 5 and 6)
    std::vector<double> radius;       ///< m: |v'_j - v'_i|
    std::vector<double> height;       ///< m: (v_j - v_i) . n
    double mean_radius = 0.0;
    double largest_radius = 0.0;
};

/// Equation 7 with the signed angles of Hormann and Floater (2006), so that
/// sum_j w_j = 1 and sum_j w_j v'_j = v'_i also where v'_i is outside the ring. May give huge or non-finite
/// weights on self-intersecting rings; see weights_are_tame().
/// @param weights receives m values. @return 0, or the limit that was taken: kOnRingEdge or kOnRingVertex.
std::uint8_t mean_value_weights(const ProjectedRing& ring, std::vector<double>& weights);

/// Whether the weights are finite and amplify an error of the neighbors at most kLargestAmplification times.
bool weights_are_tame(const std::vector<double>& weights);

/// The smallest weights (in the least-squares sense, about 1/m) with sum 1 that reproduce v'_i exactly.
/// Rotation-invariant like equation 7, bounded on rings where that one explodes.
void least_norm_weights(const ProjectedRing& ring, std::vector<double>& weights);

/// Whether the ring has three vertices or more and encloses enough area to define a plane.
bool spans_a_plane(const PositionsView& positions, const Index* ring, Index valence);

/// Collects vertices around `vertex` ring by ring, up to the third, until they span a plane, and sorts them
/// by angle about their centroid. Stands in for the one-ring at the corner of a single triangle and on folded
/// or collapsed rings.
/// @return the extended ring, or an empty one where nothing around the vertex spans a plane.
std::vector<Index> extended_ring(const PositionsView& positions, const OneRings& rings, Index vertex);

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
