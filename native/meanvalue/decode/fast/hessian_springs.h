// Springs that are added to the initial Hessian for rings whose bending it would otherwise underestimate.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The vertices whose prediction changes far more with their ring than its weights say: what hessian_springs() takes
/// of the shape alone, whatever is fixed.
struct StiffRings {
    struct Ring {
        Index vertex;
        double excess;            ///< by which the bound of its springs is taken
        std::int64_t first_norm;  ///< in norms, of as many as its valence
    };
    std::vector<Ring> rings;  ///< by vertex
    std::vector<double> norms;
};

/// The stiff rings among those of `vertices`, ascending. @param cells at rest, of the encoding. @throws Cancelled.
/// Cost: linear.
StiffRings find_stiff_rings(const Encoding& encoding, const std::vector<Index>& vertices, const RestCells& cells,
                            const Execution& execution);

/// A spoke of a row that resists by more than the smooth part of its prediction: see hessian_springs().
struct HessianSpring {
    Index row;
    Index place;  ///< in the ring
    double stiffness;
};

/// By row, then by place. @param rings of all rows at least; @param bending a_i of each row.
std::vector<HessianSpring> hessian_springs(const StiffRings& rings, const Encoding& encoding,
                                           const Unknowns& unknowns, const std::vector<double>& bending);

}  // namespace meanvalue
