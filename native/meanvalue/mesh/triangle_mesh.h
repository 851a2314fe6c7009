// The connectivity of a triangle mesh. The only pair of files that knows of OpenMesh.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A run of triangles around a vertex that hang together by their edges.
struct Fan {
    std::vector<Index> ring;  ///< neighbors, counter-clockwise seen from outside
    bool closed = false;      ///< the triangles go all the way round
};

/// @throws InvalidInput where a number is outside [0, vertex_count) or a triangle names a vertex twice.
void require_triangles(Index vertex_count, const TrianglesView& faces);

/// Which vertices are neighbors, and in which order. Positions are not part of it.
///
/// Any set of triangles is accepted. Where a triangle does not fit a manifold (a third one on an edge, one
/// turned inside out, a duplicate), it is kept as a loose piece of its own, so that its corners have further
/// fans there, or left out where all of these have closed ones, which are larger; see detached_count().
class TriangleMesh {
  public:
    /// @param faces m x 3 vertex numbers.
    /// @throws InvalidInput where a number is outside [0, vertex_count) or a triangle names a vertex twice;
    /// Cancelled.
    TriangleMesh(Index vertex_count, const TrianglesView& faces, const Execution& execution);
    ~TriangleMesh();

    /// Triangles that did not fit.
    Index detached_count() const { return detached_count_; }

    /// Appends every fan of triangles at `vertex` to `fans` after clearing it; none for a loose vertex.
    /// An inner vertex of a manifold has one closed fan, a boundary vertex one open fan.
    void collect_fans(Index vertex, std::vector<Fan>& fans) const;

  private:
    struct Connectivity;
    Index detached_count_ = 0;
    std::unique_ptr<Connectivity> connectivity_;
};

}  // namespace meanvalue
