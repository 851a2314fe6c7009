// The vocabulary of the whole core: how positions, triangles and indices are stored.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace meanvalue {

/// Vertex, triangle and half-edge numbers; 32 bits, as at the Python border.
using Index = std::int32_t;

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// n x 3, one row a vertex, row-major so that numpy's C-order arrays are seen without a copy.
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using PositionsView = Eigen::Ref<const Positions>;

/// m x 3, one row a triangle, vertices counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;
using TrianglesView = Eigen::Ref<const Triangles>;

/// Seconds spent in each named stage.
using Timings = std::map<std::string, double>;

/// The diagonal of the axis-aligned box about all rows; 0 without any.
inline double bounding_box_diagonal(const PositionsView& positions) {
    return positions.rows() == 0 ? 0.0 : (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).norm();
}

}  // namespace meanvalue
