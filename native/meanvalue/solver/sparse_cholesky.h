// Factorisation of a symmetric positive definite matrix: the one place that knows which library does it.
#pragma once

#include <memory>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/solver/block_matrix.h"

namespace meanvalue {

enum class Ordering {
    kQuick,             // the library's choice: minimum degree, unless much is to be gained
    kNestedDissection,  // takes longer; less fill on large meshes, and parts that can be worked on at the same time
};

/// The factor where the library keeps it: n columns in supernodes, which are consecutive columns with the same rows,
/// in an order in which a supernode comes directly after those that depend on it alone (a postorder of the tree).
struct FactorView {
    std::int64_t supernode_count;
    const std::int64_t* order;         // n: the row of the matrix that is row k of the factor
    const std::int64_t* first_column;  // supernode_count + 1
    const std::int64_t* first_row;     // supernode_count + 1, in rows
    const std::int64_t* rows;          // ascending for each supernode, its own columns first
    const std::int64_t* first_value;   // supernode_count + 1, in values
    const double* values;  // rows x columns by columns, above the diagonal undefined; null before factorise()
};

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
    void analyse(const SparseMatrix& lower, const Execution& execution, Ordering ordering = Ordering::kQuick);
    bool analysed() const { return state_ != nullptr; }

    /// @return false where the matrix is not positive definite to working precision.
    /// @throws Cancelled; then analysed() is false. @pre analysed().
    bool factorise(const SparseMatrix& lower, const Execution& execution);

    /// @pre factorise() returned true.
    /// @param right_hand_sides one a column.
    /// @throws Cancelled.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const;

    /// Valid until the next call of another member. @pre analysed().
    FactorView view() const;

    /// Gives back the memory of the values, the factor's and the matrix's; factorise() may be called again.
    void release_values();

  private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace meanvalue
