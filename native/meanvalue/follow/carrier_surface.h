// The surface that other parts go along with: places on it, and how the patch around a place rotates and grows.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue {

/// Vertex v. @param positions n x 3, row by row.
inline Vector3 point_at(const double* positions, Index v) {
    return Eigen::Map<const Vector3>(positions + 3 * std::ptrdiff_t{v});
}

/// A point of a triangle.
struct SurfacePlace {
    std::array<Index, 3> corners;
    Vector3 weights;  ///< of the corners, with the sum 1

    Vector3 of(const double* positions) const;
    Vector3 normal(const std::vector<Vector3>& normals) const;  ///< of unit length, or zero
};

/// A place that was found in the tree.
SurfacePlace place_on(const TriangleTree& tree, const TriangleTree::Place& found);

/// Vertices around a place, and how they lie at rest.
struct SurfacePatch {
    struct Point {
        Index vertex;
        double weight;  // all together 1
        Vector3 arm;    // from their center, times the weight
    };

    std::vector<Point> points;
    Vector3 normal = Vector3::Zero();  ///< at rest, times half the mean square of the distances from the center

    SurfacePatch() = default;
    /// @param weighted what vertices count, and these. @param normals at rest, or none.
    SurfacePatch(const std::vector<std::pair<double, Index>>& weighted, const double* rest,
                 const std::vector<Vector3>& normals = {});

    /// From the first point on: far from the origin a sum of positions would be off by more than a part is large.
    Vector3 centre(const double* positions) const;
    /// Its closest rotation is that of the patch. By their normals flat patches have full rank.
    Matrix3 covariance(const double* positions, const std::vector<Vector3>& normals = {}) const;
};

/// Edges of a surface with their lengths at rest, above 0.
struct RestEdges {
    struct Edge {
        Index a, b;
        double length;
    };
    std::vector<Edge> edges;

    void add(Index a, Index b, const double* rest);
    /// The median, which a few stretched ones do not move.
    double growth(const double* positions) const;
};

/// The faces of some parts of a mesh at rest.
class CarrierSurface {
  public:
    /// @param rest n x 3. @param part_of n, which both must outlive it. @param is_carrier of each part.
    /// @throws Cancelled. Cost: n log n.
    CarrierSurface(const PositionsView& rest, const TrianglesView& faces, const std::vector<Index>& part_of,
                   const std::vector<char>& is_carrier, const Execution& execution);

    const TriangleTree& tree() const { return tree_; }
    /// The other corners of the faces at each vertex, two by two.
    const Grouped<Index>& fans() const { return fans_; }
    const std::vector<Vector3>& normals() const { return normals_; }  ///< n: of unit length, or zero
    double mean_edge(Index v) const { return mean_edges_[v]; }
    SurfacePlace nearest(const Vector3& point) const;
    /// The vertices within `reach` of a place, by edges that do not leave it, which count by their areas and fade
    /// with their distance; the largest alone, less the largest of the others, so that what is dropped drops
    /// continuously. @param reached n, of this thread: a number that is not `mark`, where it was not called with
    /// that.
    SurfacePatch patch_at(const SurfacePlace& place, double reach, Index mark, std::vector<Index>& reached) const;

  private:
    PositionsView rest_;
    TriangleTree tree_;
    Grouped<Index> fans_;
    std::vector<Vector3> normals_;
    std::vector<double> areas_;
    std::vector<double> mean_edges_;
};

/// Twice the area of the faces around vertex v, along their normal. @param fans CarrierSurface::fans().
Vector3 area_around(const Grouped<Index>& fans, const double* positions, Index v);

}  // namespace meanvalue
