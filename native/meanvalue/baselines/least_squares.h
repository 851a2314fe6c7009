// Linear least squares over the free vertices, with everything else eliminated: docs/algorithm.md, "Baselines".
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/sparse_cholesky.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue::baselines {

/// Rows sum_j C_ij v_j, one for each of Unknowns::rows and in that order, as compressed rows.
/// Size 1: C_ij is a number and the coordinates do not mix; Size 3: C_ij is a 3 x 3 matrix.
template <int Size>
struct LinearRows {
    using Coefficient = Eigen::Matrix<double, Size, Size>;

    std::vector<std::int64_t> offsets = {0};
    std::vector<Index> vertices;
    std::vector<Coefficient> coefficients;

    /// A vertex may be added to one row several times; its coefficients are summed.
    void add(Index vertex, const Coefficient& coefficient) {
        vertices.push_back(vertex);
        coefficients.push_back(coefficient);
    }
    void end_row() { offsets.push_back(static_cast<std::int64_t>(vertices.size())); }
    Eigen::Index row_count() const { return static_cast<Eigen::Index>(offsets.size()) - 1; }

    /// The rows' values. @param positions n x 3. @return one line a row. @throws Cancelled.
    Positions apply(const PositionsView& positions, const Execution& execution) const;
};

/// Moves the free vertices in `positions` to the minimum of sum_i |sum_j C_ij v_j - wanted_i|^2; what the rows leave
/// open stays as near as can be to where it is.
/// @param wanted one line a row; @param cholesky analysed for these rows, or not at all: then it is done here.
/// @throws InvalidInput where rows are too long (RingRoom), SolverFailure, Cancelled.
template <int Size>
void minimise_rows(const LinearRows<Size>& rows, const Positions& wanted, const Unknowns& unknowns,
                   SparseCholesky& cholesky, Positions& positions, Execution& execution);

}  // namespace meanvalue::baselines
