// The one-ring of every vertex, in the order that the encoding needs it. Its .cpp alone knows of OpenMesh.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Where the neighbors of a vertex come from; OneRings::kinds.
enum class RingKind : std::uint8_t {
    kClosed,       ///< the triangles go all the way round
    kOpen,         ///< on a boundary; the ring is closed by the chord from its last to its first vertex
    kNonManifold,  ///< several fans of triangles meet here; the largest one was taken
    kLoose,        ///< in no triangle; the ring is empty
    kAbsent,       ///< not a vertex of this mesh, though it has a number; the ring is empty
};

/// The rings of all n vertices, one after another (compressed rows).
struct OneRings {
    std::vector<Index> offsets = {0};  ///< n + 1; ring i is vertices[offsets[i]] to vertices[offsets[i + 1] - 1]
    std::vector<Index> vertices;
    std::vector<RingKind> kinds;        ///< n
    std::vector<char> closed;           ///< n: the triangles of the fan that was taken go all the way round
    Index detached_triangle_count = 0;  ///< triangles that fit no manifold

    Index vertex_count() const { return static_cast<Index>(kinds.size()); }
    Index valence(Index vertex) const { return offsets[vertex + 1] - offsets[vertex]; }
    /// How many triangles the ring has; number k has the corners k and k + 1 (cyclic) and the vertex.
    Index triangle_count(Index vertex) const {
        return closed[vertex] || valence(vertex) == 0 ? valence(vertex) : valence(vertex) - 1;
    }
    /// Takes memory for so many vertices of a usual mesh: six neighbors on average, as edges are three times as many.
    void reserve(Index vertex_count);
    /// Adds the ring of the next vertex.
    void append(const Index* begin, const Index* end, RingKind kind, bool is_closed);
    const Index* begin(Index vertex) const { return vertices.data() + offsets[vertex]; }
    const Index* end(Index vertex) const { return vertices.data() + offsets[vertex + 1]; }
};

/// @throws InvalidInput where a number is outside [0, vertex_count) or a triangle names a vertex twice.
void require_triangles(Index vertex_count, const TrianglesView& faces);
/// @param vertices_name, faces_name what the caller calls them. @throws InvalidInput as that, and for vertices that
/// are not finite or too far apart.
void require_mesh(const Positions& vertices, const Triangles& faces, const char* vertices_name,
                  const char* faces_name);

/// The ring of every vertex, counter-clockwise seen from outside. Any set of triangles is accepted: where a triangle
/// does not fit a manifold (a third one on an edge, one turned inside out, a duplicate), it is a fan of its own at
/// its corners, or left out where all of these have closed ones, which are larger. @param faces m x 3. @throws
/// InvalidInput where a number is outside [0, vertex_count) or a triangle names a vertex twice; Cancelled. Cost:
/// linear.
OneRings collect_one_rings(Index vertex_count, const TrianglesView& faces, const Execution& execution);

}  // namespace meanvalue
