// The one-ring of every vertex, in the order that the encoding needs it.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/triangle_mesh.h"

namespace meanvalue {

/// Where the neighbours of a vertex come from; OneRings::kind.
enum class RingKind : std::uint8_t {
    kClosed,       ///< the triangles go all the way round
    kOpen,         ///< on a boundary; the ring is closed by the chord from its last to its first vertex
    kNonManifold,  ///< several fans meet here; the largest one was taken
    kLoose,        ///< in no triangle; the ring is empty
    kAbsent,       ///< not a vertex of this mesh, though it has a number; the ring is empty
};

/// The rings of all n vertices, one after another (compressed rows).
struct OneRings {
    std::vector<Index> offsets = {0};  ///< n + 1; ring i is vertices[offsets[i]] to vertices[offsets[i + 1] - 1]
    std::vector<Index> vertices;
    std::vector<RingKind> kinds;  ///< n
    std::vector<char> closed;     ///< n: the triangles of the fan that was taken go all the way round

    Index vertex_count() const { return static_cast<Index>(kinds.size()); }
    Index valence(Index vertex) const { return offsets[vertex + 1] - offsets[vertex]; }
    /// Of the triangles of the ring; number k has the corners k and k + 1 (cyclic) and the vertex.
    Index triangle_count(Index vertex) const {
        return closed[vertex] || valence(vertex) == 0 ? valence(vertex) : valence(vertex) - 1;
    }
    /// Adds the ring of the next vertex.
    void append(const Index* begin, const Index* end, RingKind kind, bool is_closed);
    /// The same: that of its largest fan.
    void append(const std::vector<Fan>& fans);
    const Index* begin(Index vertex) const { return vertices.data() + offsets[vertex]; }
    const Index* end(Index vertex) const { return vertices.data() + offsets[vertex + 1]; }
};

/// Reads the ring of every vertex off the mesh, counter-clockwise seen from outside. Cost: linear.
/// @throws Cancelled.
OneRings collect_one_rings(const TriangleMesh& mesh, const Execution& execution);

}  // namespace meanvalue
