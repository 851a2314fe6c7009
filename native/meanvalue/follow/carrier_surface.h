// The surface that clothes go along with: places on it, and how the patch around a place rotates.
#pragma once

#include <array>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Vertex v. @param positions n x 3, row by row.
template <typename Scalar>
Vector3 point_at(const Scalar* positions, Index v) {
    return Eigen::Map<const Eigen::Matrix<Scalar, 3, 1>>(positions + 3 * static_cast<std::ptrdiff_t>(v))
        .template cast<double>();
}

/// A point of a triangle.
struct SurfacePlace {
    std::array<Index, 3> corners;
    Vector3 weights;  ///< of the corners, with the sum 1

    /// From the first corner on: far from the origin a sum of positions would be off.
    Vector3 of(const double* positions) const {
        const Vector3 first = point_at(positions, corners[0]);
        return first + weights[1] * (point_at(positions, corners[1]) - first) +
               weights[2] * (point_at(positions, corners[2]) - first);
    }
    Vector3 normal(const std::vector<Vector3>& normals) const;  ///< of unit length, or zero
};

/// Vertices around a place, and how they lie at rest.
struct SurfacePatch {
    static constexpr int kMost = 12;

    std::array<Index, kMost> points{};
    std::array<double, kMost> weights{};  ///< summing to 1
    std::array<Vector3, kMost> arms{};    ///< from their weighted center, times their weights
    Vector3 normal = Vector3::Zero();     ///< times half the mean square of the distances from the center
    int count = 0;

    /// Its closest rotation is that of the patch. Flat patches have full rank by their normals.
    Matrix3 covariance(const double* positions, const std::vector<Vector3>& normals) const;
};

/// The faces of a carrier at rest, with what is needed to find patches in them and normals of them when posed.
class CarrierSurface {
  public:
    /// @param rest n x 3. @param faces of the carrier alone. @param size its mean_diagonal(). @throws Cancelled.
    /// Cost: linear.
    CarrierSurface(const PositionsView& rest, Triangles faces, double size, int threads, const Execution& execution);

    const Triangles& faces() const { return faces_; }
    double size() const { return size_; }
    const std::vector<Vector3>& rest_normals() const { return rest_normals_; }
    double mean_edge(Index v) const { return mean_edges_[v]; }
    Grouped<Index>::Range neighbours(Index v) const { return neighbours_.of(v); }

    /// n: unit normals of `vertices` where they are posed, zero where there is none; other entries stay.
    void find_normals(const double* positions, const std::vector<Index>& vertices, int threads,
                      const Execution& execution, std::vector<Vector3>& normals) const;

    /// What a search for patches writes, for any number of them.
    struct Scratch {
        std::vector<double> distances;  // n
        std::vector<Index> reached;
    };
    /// The vertices within `reach` of a place by ways along edges, which count by their areas and fade with their
    /// distance; the largest alone, less the largest of the others, so that what is dropped drops continuously.
    SurfacePatch patch_at(const double* rest, const SurfacePlace& place, double reach, Scratch& scratch) const;

  private:
    Triangles faces_;
    Grouped<Index> faces_at_;
    Grouped<Index> neighbours_;  // those over inner edges are there twice
    std::vector<double> mean_edges_;
    std::vector<double> areas_;
    std::vector<Vector3> rest_normals_;
    double size_;
};

}  // namespace meanvalue
