// The multiresolution encoding: vertices removed one by one, each with its encoding at that time (paper,
// section 3.1).
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/triangle_mesh.h"

namespace meanvalue {

/// The mesh at one moment of the coarsening.
struct Level {
    std::size_t removed_count = 0;  ///< how many of Hierarchy::order were gone
    Encoding encoding;              ///< n rows: every vertex that was still there, by its ring then
};

/// A removal order with all that is needed to undo it for other positions. Vertex numbers stay those of the mesh.
struct Hierarchy {
    std::vector<Index> order;  ///< removed vertices, first removed first
    /// n rows: each removed vertex by its ring at removal. A split places it by them; others are not predictable.
    Encoding splits;
    std::vector<RingKind> split_kinds;  ///< n: of those rings
    std::vector<Level> levels;         ///< those asked for, finest first, and the base mesh last
    std::vector<Index> base_unknowns;  ///< removable vertices that no legal collapse could remove, ascending

    const Level& base() const { return levels.back(); }
    Index longest_ring() const;  ///< of all rings in `splits` and `levels`
    std::size_t bytes() const;
};

/// Removes vertices by half-edge collapses, cheapest first, until none can be removed. A collapse is legal where it
/// keeps topology and boundary, bounds the rings, and leaves the removed vertex with a stencil that does not amplify.
/// @param mesh is coarsened in place.
/// @param positions n x 3; never changed.
/// @param removable n flags: the others (anchors) stay in every level.
/// @param level_sizes numbers of removable vertices, descending: a level is kept when so many are left.
/// @throws Cancelled. Cost: about linear times the logarithm of the vertex count; serial, the order is always the
/// same.
Hierarchy build_hierarchy(TriangleMesh& mesh, const PositionsView& positions, const std::vector<char>& removable,
                          const std::vector<Index>& level_sizes, int threads, Execution& execution);

}  // namespace meanvalue
