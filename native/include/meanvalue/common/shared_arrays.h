// Meshes as callers give them: copied once from any layout, then owned and never changed.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <memory>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

using SharedPositions = std::shared_ptr<const Positions>;
using SharedTriangles = std::shared_ptr<const Triangles>;

/// A copy of a matrix or map of Eigen's of double or int, row-major or column-major.
/// @throws InvalidInput by `name` unless there are three columns.
template <typename Derived>
auto share(const Eigen::MatrixBase<Derived>& matrix, const char* name) {
    if (matrix.cols() != 3) throw InvalidInput(message(name, " has ", matrix.cols(), " columns; give 3"));
    return std::make_shared<const Rows<typename Derived::Scalar>>(matrix);
}

/// What is shared already.
inline SharedPositions share(SharedPositions positions, const char* /*name*/) {
    return positions;
}
inline SharedTriangles share(SharedTriangles triangles, const char* /*name*/) {
    return triangles;
}

}  // namespace meanvalue
