// Factorisation of a symmetric positive definite matrix: the one place that knows which library does it.
#pragma once

#include <memory>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/solver/block_matrix.h"

namespace meanvalue {

/// Cholesky factor of a matrix given by its lower triangle; entries above the diagonal are ignored.
/// Supernodal, by CHOLMOD (docs/decisions/0002-sparse-cholesky.md).
/// A cancelled call returns within milliseconds; the library's own loop is left to end by itself.
class SparseCholesky {
  public:
    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Fill-reducing order and symbolic analysis; once for each pattern.
    /// @throws Cancelled, SolverFailure.
    void analyse(const SparseMatrix& lower, const Execution& execution);
    bool analysed() const { return state_ != nullptr; }

    /// @return false where the matrix is not positive definite to working precision.
    /// @throws Cancelled; then analysed() is false. @pre analysed().
    bool factorise(const SparseMatrix& lower, const Execution& execution);

    /// @pre factorise() returned true.
    Eigen::VectorXd solve(const Eigen::VectorXd& right_hand_side) const;
    /// Several right-hand sides at once, one a column.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides) const;

  private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace meanvalue
