// The mean of positions, with the same bits wherever the result is kept.
#pragma once

#include "meanvalue/common/types.h"

namespace meanvalue {

/// The mean of all rows, summed one after the other: the bits of Eigen's own depend on where its result is in memory.
inline Vector3 mean_row(const PositionsView& positions) {
    Vector3 sum = Vector3::Zero();
    for (Eigen::Index k = 0; k < positions.rows(); ++k)
        sum += positions.row(k).transpose();
    return sum / static_cast<double>(positions.rows());
}

}  // namespace meanvalue
