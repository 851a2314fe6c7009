#include "meanvalue/common/checks.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// Areas are squared on the way, so that the fourth power must fit.
constexpr double kLeastExtent = 1e-60;
constexpr double kMostExtent = 1e60;

}  // namespace

void require_count(const char* name, std::size_t size, const char* unit, std::size_t count, const char* of) {
    if (size == count) return;
    throw InvalidInput(message(name, " has ", size, " ", unit, "s, but there are ", count, " ", of, "; give one ",
                               unit, " for each"));
}

void require_finite(const PositionsView& positions, const char* name) {
    if (positions.allFinite()) return;
    for (Eigen::Index row = 0; row < positions.rows(); ++row) {
        if (positions.row(row).allFinite()) continue;
        throw InvalidInput(message(name, "[", row, "] is (", positions(row, 0), ", ", positions(row, 1), ", ",
                                   positions(row, 2), "); every coordinate must be a finite number"));
    }
}

void require_finite_result(const PositionsView& positions, const char* name) {
    if (positions.allFinite()) return;
    throw InvalidInput(message(name,
                               " lie so far outside 0 to 1 that the shape has no finite coordinates; give numbers ",
                               "nearer to that"));
}

void require_moderate_extent(const PositionsView& vertices) {
    if (vertices.rows() == 0) return;
    // Each axis by itself: the diagonal's square is what may overflow.
    const double extent = (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).maxCoeff();
    if (extent == 0.0 || (extent > kLeastExtent && extent < kMostExtent)) return;
    throw InvalidInput(
        message("vertices span ", extent, " units; scale the mesh to between ", kLeastExtent, " and ", kMostExtent));
}

}  // namespace meanvalue
