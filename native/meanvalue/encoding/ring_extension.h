// A wider ring for a vertex whose own neighbors define no plane.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// Whether the ring has three vertices or more and encloses enough area to define a plane.
bool spans_a_plane(const PositionsView& positions, const Index* ring, Index valence);

/// Collects vertices around `vertex` ring by ring, up to the third, until they span a plane, and sorts them
/// by angle about their centroid. Stands in for the one-ring at the corner of a single triangle and on folded
/// or collapsed rings.
/// @return the extended ring, or an empty one where nothing around the vertex spans a plane.
std::vector<Index> extended_ring(const PositionsView& positions, const OneRings& rings, Index vertex);

}  // namespace meanvalue
