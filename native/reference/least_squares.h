// Linear least squares over the free vertices, with everything else eliminated: docs/algorithm.md, "Baselines".
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "meanvalue/linalg/supernodal_factor.h"
#include "reference/problem.h"

namespace meanvalue::baselines {

/// One line a residual, one column an unknown.
using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int64_t>;
using RowEntry = Eigen::Triplet<double, std::int64_t>;

/// A ring couples all pairs of its vertices in the normal matrix. @throws InvalidInput where one is too long for
/// that.
void require_short_rings(const Setup& setup);

/// Moves the free unknowns in `values` to the minimum of |rows * values - wanted|^2; what the rows leave open stays
/// as near as can be to where it is.
/// @param wanted one line a row; @param free columns of `rows`, ascending. @param cholesky analyzed for these rows,
/// or not at all: then it is done here. @param values one line an unknown, as many columns as `wanted`.
/// @throws SolverFailure, Cancelled.
void minimise_rows(const Rows& rows, const Eigen::MatrixXd& wanted, const std::vector<Index>& free,
                   SparseCholesky& cholesky, Eigen::MatrixXd& values, const Execution& execution);

}  // namespace meanvalue::baselines
