// The vocabulary of the whole core: how positions, triangles and indices are stored.
#pragma once  // SPDX-License-Identifier: MPL-2.0

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

/// Rows of three, row-major so that numpy's C-order arrays are seen without a copy. Not aligned, so that their memory
/// is malloc's: a program that is compiled for other instructions than this library has another allocator of Eigen's,
/// and takes and frees what crosses the border.
template <typename Scalar>
using Rows =
    Eigen::Matrix<Scalar, Eigen::Dynamic, 3, static_cast<int>(Eigen::RowMajor) | static_cast<int>(Eigen::DontAlign)>;

/// n x 3, one row a vertex.
using Positions = Rows<double>;
using PositionsView = Eigen::Ref<const Positions>;

/// m x 3, one row a triangle, vertices counter-clockwise seen from outside.
using Triangles = Rows<Index>;
using TrianglesView = Eigen::Ref<const Triangles>;

/// Seconds spent in each named stage.
using Timings = std::map<std::string, double>;

/// The diagonal of the axis-aligned box about all rows; 0 without any.
inline double bounding_box_diagonal(const PositionsView& positions) {
    return positions.rows() == 0 ? 0.0 : (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).norm();
}

}  // namespace meanvalue
