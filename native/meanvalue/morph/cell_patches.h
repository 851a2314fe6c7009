// Cells of a mesh in patches that go smoothly over into each other.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {

/// Connected patches of some dozen vertices that have a ring, and how much each vertex belongs to those around it.
struct CellPatches {
    struct Share {
        Index patch;
        double share;
    };

    /// @throws Cancelled. Cost: linear, in rounds that grow with the square root of the vertices in a patch.
    CellPatches(const OneRings& rings, const Execution& execution);

    Index count() const { return static_cast<Index>(sizes.size()); }

    /// The average of the rotations of the patches around a vertex, by their shares. @param rotations one for each
    /// patch, `stride` apart.
    Quaternion mean_rotation(Index vertex, const Quaternion* rotations, std::size_t stride) const;
    /// patches x k: the average weights of their vertices.
    std::vector<double> mean_weights(const ShapeWeights& weights) const;

    std::vector<Index> of;           ///< n: -1 for vertices without a ring
    std::vector<Index> sizes;        ///< in vertices
    std::vector<Index> share_start;  ///< n + 1
    std::vector<Share> shares;       ///< of patches in the cells, which sum to 1

  private:
    void grow(const OneRings& rings, const Execution& execution);
    void spread(const OneRings& rings, const Execution& execution);
};

}  // namespace meanvalue
