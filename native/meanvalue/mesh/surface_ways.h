// How far it is from some vertices to the others over the surface of a mesh, of whatever pieces it is made.
#pragma once

#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Ways go along edges, and step over to another piece where the surfaces of two touch or nearly touch; the gap
/// between them counts as nothing, so that layers over each other are equally far.
class SurfaceWays {
  public:
    using Edges = Eigen::Matrix<Index, Eigen::Dynamic, 2, Eigen::RowMajor>;
    using EdgesView = Eigen::Ref<const Edges>;

    /// Nearly means as near as `gap`, or as half the shortest edge at a vertex.
    /// @param positions n x 3, of which some may not be finite. @param triangles the surfaces of the pieces, in the
    /// numbers of the vertices of `edges`; none: pieces stay apart.
    /// @throws InvalidInput for numbers of no vertex, Cancelled. Cost: linear for one piece, n log n for several.
    SurfaceWays(Positions positions, const EdgesView& edges, const TrianglesView& triangles, double gap, int threads,
                const Execution& execution);

    /// n: about how far each vertex is from the nearest seed, infinite beyond `limit`, and -1 in pieces without a
    /// seed of which no vertex is beyond it. Straight to the seed that is nearest by ways, so that what is equally
    /// far lies on a circle where the surface is flat, whatever its faces are; but no less than the way says, which
    /// is longer than one over the faces by up to sqrt(2) on a grid of squares: what is folded back to the seeds is
    /// not near. @throws InvalidInput for a seed that is no vertex. Cost: that of what is within sqrt(2) times the
    /// limit, in a queue (Dijkstra).
    std::vector<double> distances(const std::vector<Index>& seeds, double limit) const;

    /// n, 0 to 1: how much each vertex follows: 1 up to the share `free` of the limit and in pieces without a seed
    /// that lie completely within it, 0 from the limit on, and 3 t^2 - 2 t^3 between, without a kink at either end.
    /// However small the limit is, it counts as two edges and a half, or no vertex would follow. @throws
    /// InvalidInput.
    std::vector<double> falloff(const std::vector<Index>& seeds, double limit, double free) const;

    /// How far the limb goes whose end or side the vertex is on, at least `least`, which passes over fingers, and at
    /// most `limit`; 0 where it is on none.
    ///
    /// Lines of equal distance cross a limb as rings of about one size, and are wide where it meets the body. A limb
    /// is several times as long as the widest ring, and ends where rings have become so wide that this is lost.
    double limb(Index vertex, double least, double limit) const;

    /// n: the lowest vertex of the connected piece of each.
    const std::vector<Index>& parts() const { return part_of_; }

  private:
    struct Step {  // from one vertex over a gap to one of another piece
        Index from, to;
        float length;
        Eigen::Vector3f gap;  // what is stepped over
    };

    SurfaceWays() = default;

    void require_vertices(const std::vector<Index>& seeds) const;
    std::vector<double> reach(const std::vector<Index>& seeds, double limit) const;
    void find_steps(const EdgesView& edges, const TrianglesView& triangles, double gap, int threads,
                    const Execution& execution);
    SurfaceWays coarser(Index& vertex) const;
    double limb_within(Index vertex, const std::vector<double>& distances, double least, double limit) const;
    double widest_ring(const std::vector<std::pair<Index, Index>>& crossed, const std::vector<double>& distances,
                       double level, std::vector<Index>& place) const;

    Positions positions_;
    std::vector<Index> part_of_;
    Grouped<Index> neighbours_;
    Grouped<Step> steps_;  // by `from`
};

}  // namespace meanvalue
