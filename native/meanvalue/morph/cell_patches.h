// Connected patches of the cells of a mesh.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// Connected patches of some dozen vertices that have a ring.
struct CellPatches {
    std::vector<Index> of;     ///< n: the patch of each vertex, -1 for vertices without a ring
    std::vector<Index> sizes;  ///< of each patch, in vertices

    Index count() const { return static_cast<Index>(sizes.size()); }
};

/// Grows patches of equal numbers of vertices; what is left over between them joins a neighbour.
/// @param layout the rings, n. @throws Cancelled. Cost: linear.
CellPatches grow_patches(const Encoding& layout, const Execution& execution);

}  // namespace meanvalue
