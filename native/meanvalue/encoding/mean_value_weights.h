// Mean-value coordinates of a point in a plane polygon, and what stands in for them where they break down.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

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

}  // namespace meanvalue
