// What a vertex may be merged into, by whether it is fixed or soft and by the shape around it.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "meanvalue/hierarchy/fixed_parts.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {

/// The rules for a mesh that is being coarsened. @pre all that it is made with outlives it.
class RemovalRules {
  public:
    RemovalRules(const RingMesh& mesh, const OneRings& rings, const PositionsView& positions,
                 const std::vector<char>& is_fixed, const CoarseningOptions& options);

    bool is_fixed(Index vertex) const { return is_fixed_[vertex] != 0; }
    bool is_soft(Index vertex) const { return !soft_parts_.part.empty() && soft_parts_.part[vertex] >= 0; }
    bool is_removable(Index vertex) const;
    /// Whether it can have a collapse at all. Looking at longer rings, at each change of one, would be cubic in the
    /// valence; such a vertex is considered once its ring has shrunk.
    bool is_short(Index vertex) const { return mesh_.ring(vertex).valence <= RingMesh::kLongestRemovable; }
    /// A fixed vertex may only be merged into its own part, or the part would shrink away under free ones. The same
    /// holds for soft ones.
    bool may_become(Index vertex, Index to) const;
    /// The cheapest collapse, or one that leads nowhere.
    Collapse cheapest(Index vertex, CollapseCost& cost) const;
    /// Whether the vertex can be put back by equation 7 and 13 without amplifying errors.
    bool has_good_stencil(Index vertex, RingEncoder& encoder) const;

  private:
    const RingMesh& mesh_;
    const PositionsView& positions_;
    const std::vector<char>& is_fixed_;
    FixedParts parts_;       // empty where no fixed vertex may be removed
    FixedParts soft_parts_;  // the same of soft vertices; empty where there are none
};

}  // namespace meanvalue
