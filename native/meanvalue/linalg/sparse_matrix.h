// The sparse matrices that are factored.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>

namespace meanvalue {

/// 64-bit offsets: the factor of a million free vertices has more than 2^31 entries.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

}  // namespace meanvalue
