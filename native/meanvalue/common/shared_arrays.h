// Meshes as callers give them: copied once from any layout, then owned and never changed.
#pragma once

#include <memory>

#include "meanvalue/common/types.h"

namespace meanvalue {

using SharedPositions = std::shared_ptr<const Positions>;
using SharedTriangles = std::shared_ptr<const Triangles>;

/// A matrix in memory of the caller's, looked at while it is copied.
template <typename Scalar>
struct StridedMatrix {
    const Scalar* data;
    Eigen::Index rows;
    Eigen::Index columns;
    Eigen::Index row_stride;
    Eigen::Index column_stride;
};

/// Copies it into memory that this library takes and frees: a program that is compiled for other instructions may
/// have another allocator of Eigen's. @throws InvalidInput by `name` unless there are three columns.
SharedPositions copy_shared(const StridedMatrix<double>& matrix, const char* name);
SharedTriangles copy_shared(const StridedMatrix<Index>& matrix, const char* name);

/// The same of a matrix or map of Eigen's of double or int, row-major or column-major.
template <typename Derived>
auto share(const Eigen::MatrixBase<Derived>& matrix, const char* name) {
    static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0, "give a matrix or a map, not an expression");
    const Derived& given = matrix.derived();
    return copy_shared(StridedMatrix<typename Derived::Scalar>{given.data(), given.rows(), given.cols(),
                                                               given.rowStride(), given.colStride()},
                       name);
}

/// What is shared already.
inline SharedPositions share(SharedPositions positions, const char* /*name*/) {
    return positions;
}
inline SharedTriangles share(SharedTriangles triangles, const char* /*name*/) {
    return triangles;
}

}  // namespace meanvalue
