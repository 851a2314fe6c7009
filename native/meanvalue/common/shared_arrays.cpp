#include "meanvalue/common/shared_arrays.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

template <typename Array>
std::shared_ptr<const Array> copy(const StridedMatrix<typename Array::Scalar>& matrix, const char* name) {
    if (matrix.columns != 3) throw InvalidInput(message(name, " has ", matrix.columns, " columns; give 3"));
    using Strides = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
    return std::make_shared<const Array>(Eigen::Map<const Array, Eigen::Unaligned, Strides>(
        matrix.data, matrix.rows, 3, Strides(matrix.row_stride, matrix.column_stride)));
}

}  // namespace

SharedPositions copy_shared(const StridedMatrix<double>& matrix, const char* name) {
    return copy<Positions>(matrix, name);
}

SharedTriangles copy_shared(const StridedMatrix<Index>& matrix, const char* name) {
    return copy<Triangles>(matrix, name);
}

}  // namespace meanvalue
