// Cells of a mesh in patches that go smoothly over into each other.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// Connected patches of some dozen vertices that have a ring, and how much each vertex belongs to those around it.
struct CellPatches {
    struct Share {
        Index patch;
        double share;
    };

    /// @param layout the rings, n. @throws Cancelled. Cost: linear.
    CellPatches(const Encoding& layout, const Execution& execution);

    Index count() const { return static_cast<Index>(sizes.size()); }

    std::vector<Index> of;           ///< n: -1 for vertices without a ring
    std::vector<Index> sizes;        ///< in vertices
    std::vector<Index> share_start;  ///< n + 1
    std::vector<Share> shares;       ///< of patches in the cells, which sum to 1

  private:
    void grow(const Encoding& layout, const Execution& execution);
    void spread(const Encoding& layout, const Execution& execution);
};

}  // namespace meanvalue
