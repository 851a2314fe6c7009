// Factorisation of a symmetric positive definite matrix in double precision.
#pragma once

#include <memory>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/block_matrix.h"
#include "meanvalue/linalg/supernodal_pattern.h"

namespace meanvalue {

/// Cholesky factor of a matrix given by its lower triangle; entries above the diagonal are ignored.
/// Supernodal, in the order of a nested dissection (docs/decisions/0010-own-cholesky.md).
///
/// The bits do not depend on the number of threads, nor on what else runs. They may differ between processors with
/// and without AVX2. A cancelled call returns within milliseconds.
class SparseCholesky {
  public:
    explicit SparseCholesky(InstructionSet instructions = InstructionSet::kFastest) : instructions_(instructions) {}

    /// Fill-reducing order and symbolic analysis; once for each pattern.
    /// @param threads as given by thread_count(). @param order see find_supernodes().
    /// @throws Cancelled, SolverFailure where memory is short; then analysed() is false.
    void analyse(const SparseMatrix& lower, const Execution& execution, int threads = 1,
                 const std::vector<Index>& order = {});
    bool analysed() const { return analysis_ != nullptr; }
    /// Another one for matrices of the pattern that was analysed, for another thread; not factored yet.
    SparseCholesky of_same_pattern() const;

    /// @param lower with the pattern that was analysed. @param threads as given by thread_count().
    /// @return false where the matrix is not positive definite to working precision.
    /// @throws Cancelled, SolverFailure where memory is short; then it may be called again. @pre analysed().
    bool factorise(const SparseMatrix& lower, const Execution& execution, int threads = 1);

    /// Of the factor, once there is one. @pre analysed().
    std::size_t bytes() const { return static_cast<std::size_t>(analysis_->first_value.back()) * sizeof(double); }

    /// May be called from several threads at once. @pre factorise() returned true, the last time.
    /// @param right_hand_sides one a column.
    /// @throws Cancelled.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const;

    /// @pre analysed().
    const SupernodalPattern& pattern() const { return analysis_->pattern; }

  private:
    struct Analysis {
        SupernodalPattern pattern;
        std::vector<std::int64_t> first_value = {0};  // of each supernode's panel: row_count x width by columns
    };

    InstructionSet instructions_;
    std::shared_ptr<const Analysis> analysis_;
    std::unique_ptr<double[]> values_;
};

/// What is thrown where the memory does not suffice for a system. @param action what could not be done.
[[noreturn]] void throw_too_large(const SparseMatrix& lower, const char* action);

}  // namespace meanvalue
