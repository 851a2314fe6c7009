#include "meanvalue/common/checks.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {

void require_finite(const PositionsView& positions, const char* name) {
    if (positions.allFinite()) return;
    for (Eigen::Index row = 0; row < positions.rows(); ++row) {
        if (positions.row(row).allFinite()) continue;
        throw InvalidInput(message(name, "[", row, "] is (", positions(row, 0), ", ", positions(row, 1), ", ",
                                   positions(row, 2), "); every coordinate must be a finite number"));
    }
}

}  // namespace meanvalue
