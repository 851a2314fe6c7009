// Applying a step of the free vertices to all positions.
#pragma once

#include "meanvalue/common/types.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// to = from + length * direction in the free vertices' rows; the others are not touched.
/// @param from, to n x 3; @param direction 3 |V'|, in the order of Unknowns::free.
inline void move_free(const Unknowns& unknowns, const Positions& from, const Eigen::VectorXd& direction,
                      double length, Positions& to) {
    for (std::size_t k = 0; k < unknowns.free.size(); ++k) {
        const Index v = unknowns.free[k];
        to.row(v) = from.row(v) + length * direction.segment<3>(3 * static_cast<Eigen::Index>(k)).transpose();
    }
}

}  // namespace meanvalue
