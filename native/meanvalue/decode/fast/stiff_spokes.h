// Springs in the constant matrix for rows that it would otherwise know too little of.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/fast/rest_cells.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// A spoke of a row that resists by more than the smooth part of its prediction: see find_stiff_spokes().
struct StiffSpoke {
    Index row;
    Index place;  ///< in the ring
    double stiffness;
};

/// Of rows whose prediction changes far more with their ring than its weights say; by row, then by place. @param
/// bending a_i of each row. @throws Cancelled.
std::vector<StiffSpoke> find_stiff_spokes(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                          const std::vector<double>& bending, const Execution& execution);

}  // namespace meanvalue
