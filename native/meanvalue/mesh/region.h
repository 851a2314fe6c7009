// The part of a mesh that free vertices and their surroundings make up: what is far from them takes no part.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A part of a mesh with vertex numbers of its own.
struct Region {
    std::vector<Index> vertices;  ///< the numbers in the whole mesh; ascending but for in_spatial_order()
    Positions positions;          ///< of these vertices
    Triangles faces;              ///< in the region's numbers
    std::vector<char> is_fixed;   ///< of these vertices
};

/// `is_fixed` without small patches of anchors (up to a 64th of what may move and hangs together there, and single
/// ones), so that a region is the same when an anchor is added or removed.
/// @param is_fixed n flags; @param may_move n flags: all that is fixed of these are anchors. @throws Cancelled.
/// Cost: linear.
std::vector<char> without_small_patches(std::vector<char> is_fixed, const std::vector<char>& may_move,
                                        const TrianglesView& faces, const Execution& execution);

/// All free vertices and two rings of fixed ones around them, so that the ring of every vertex next to a free one is
/// complete. @param positions n x 3; @param is_fixed n flags. @throws Cancelled. Cost: linear.
Region surroundings_of_free(const PositionsView& positions, const TrianglesView& faces,
                            const std::vector<char>& is_fixed, const Execution& execution);

/// The parts of a region that hang together by its faces, at least one, ordered by their first vertex; each with its
/// vertices along a Z-order curve (Morton 1966), and its faces in the order of their first corners: neighbors on the
/// surface are mostly neighbors in memory, whatever order the mesh came in and however it was rotated, and nothing of
/// a part depends on the others. @throws Cancelled. Cost: that of sorting.
std::vector<Region> parts_in_spatial_order(const Region& region, const Execution& execution);

}  // namespace meanvalue
