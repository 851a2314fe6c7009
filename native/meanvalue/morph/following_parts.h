// Small parts of a mesh (eyes, teeth, buttons) that go along with a larger one from shape to shape.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/follow/loose_parts.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Placed each by itself, a part is at the average of its own positions: an eye of a head that rotates would go
/// straight while the head goes round. So each shape carries it along with the surface that is near to it there
/// (LooseParts), and it is placed by the average of that. At each shape alone it is where that shape has it.
class FollowingParts {
  public:
    /// No part follows.
    FollowingParts() = default;

    /// Parts follow that are much smaller than the largest one and not anchored, if they go from each shape to the
    /// next as the surface carries them.
    /// @param shapes n x 3 each; @param components with the anchors of each part. The same bits for any `threads`.
    /// @throws Cancelled.
    /// Cost: n log n for each shape where there are small parts; else linear.
    FollowingParts(const std::vector<PositionsView>& shapes, const TrianglesView& faces, Components components,
                   int threads, const Execution& execution);

    /// Whether the part of a vertex follows.
    bool follows(Index vertex) const { return !follows_.empty() && follows_[vertex] != 0; }
    bool empty() const { return carried_by_.empty(); }

    /// Where the vertices of parts that follow belong, beside all others.
    /// @param shapes as for the constructor. @param positions n x 3, others' rows of which are read.
    /// @return n x 3; the rows of others are those of `positions`. @throws Cancelled.
    Positions carried(const std::vector<PositionsView>& shapes, const ShapeWeights& weights,
                      const Positions& positions, int threads, const Execution& execution) const;

  private:
    /// @return whether each part that may follow goes from shape to shape, round about, as it is carried.
    std::vector<char> parts_carried_along(const std::vector<PositionsView>& shapes, const Components& components,
                                          const std::vector<char>& may_follow, int threads,
                                          const Execution& execution) const;

    std::vector<char> follows_;           // n, or empty
    std::vector<Index> vertices_;         // that do
    std::vector<LooseParts> carried_by_;  // in each shape
};

}  // namespace meanvalue
