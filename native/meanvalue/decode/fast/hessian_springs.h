// Springs that are added to the initial Hessian for rings whose bending it would otherwise underestimate.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// A spoke of a row that resists by more than the smooth part of its prediction: see hessian_springs().
struct HessianSpring {
    Index row;
    Index place;  ///< in the ring
    double stiffness;
};

/// By row, then by place. @param cells at rest, of the encoding; @param bending a_i of each row.
/// The same for any number of threads. @throws Cancelled. Cost: linear.
std::vector<HessianSpring> hessian_springs(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                           const std::vector<double>& bending, int threads,
                                           const Execution& execution);

}  // namespace meanvalue
