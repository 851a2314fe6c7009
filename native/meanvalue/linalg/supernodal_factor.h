// Cholesky factors of sparse matrices, stored in double or in single precision.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/supernodal_kernels.h"
#include "meanvalue/linalg/supernodal_pattern.h"

namespace meanvalue {

/// Cholesky factor of a symmetric positive definite n x n matrix, of which only the lower triangle is read. It is
/// supernodal, in the order of a nested dissection (docs/decisions/0010-own-cholesky.md), and always computed in
/// double precision. `Number` is what it is stored and applied in.
///
/// The bits of a solution do not depend on the number of threads, nor on what else runs. They may differ between
/// processors with and without AVX2. Once factored it is not written to: any number of threads may solve with it,
/// each with a Workspace of its own.
template <typename Number>
class CholeskyFactor {
  public:
    explicit CholeskyFactor(InstructionSet instructions = InstructionSet::kFastest) : instructions_(instructions) {}

    /// What a solve writes besides its result; for factors of any sizes, one after another.
    struct Workspace {
        Number* row(Index place) { return rows.data() + static_cast<std::size_t>(place) * kStride; }

        std::vector<Number> rows;
        std::vector<std::vector<Lanes<Number>>> blocks;  ///< one a worker
        double scale = 1.0;                              ///< of the right-hand sides
    };

    /// Fill-reducing order, symbolic analysis and the division into tasks; once for each pattern.
    /// @param threads as given by thread_count(). @param order see find_supernodes().
    /// @throws Cancelled, SolverFailure; then analysed() is false.
    void analyse(const SparseMatrix& lower, const Execution& execution, int threads = 1,
                 const std::vector<Index>& order = {});
    bool analysed() const { return analysis_ != nullptr; }
    /// Another one for matrices of the pattern that was analysed; not factored yet.
    CholeskyFactor with_same_pattern() const;

    /// Factors a matrix with the pattern that was analysed; may be called again with other values. What is moved here
    /// is freed before the numbers of the factor are found.
    /// @return false where the matrix is not positive definite to working precision.
    /// @throws Cancelled, SolverFailure; then it may be called again. @pre analysed().
    bool factorise(SparseMatrix lower, const Execution& execution, int threads = 1);

    /// x in matrix * x = right_hand_sides, for three right-hand sides; a workspace that was used before allocates
    /// little.
    /// @param right_hand_sides n x 3. @param solution n x 3; may be the same memory.
    /// @param threads as given by thread_count(); small systems take fewer.
    /// @throws Cancelled; `solution` is then half written. @pre factorise() returned true, the last time.
    void solve(const PositionsView& right_hand_sides, Eigen::Ref<Positions> solution, int threads,
               const Execution& execution, Workspace& workspace) const;
    /// The same in one thread for any number of right-hand sides, one a column.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const;

    Index size() const { return analysis_ == nullptr ? 0 : analysis_->pattern.size(); }
    /// What it keeps, without what the analysis keeps for factorizing again.
    std::size_t bytes() const;
    /// @pre analysed().
    const SupernodalPattern& pattern() const { return analysis_->pattern; }

  private:
    /// The rows of the tasks above that a task adds to: they have places of their own in the work vector, so that no
    /// two tasks write the same place. The parent adds them to its own, child after child.
    struct UpdateRows {
        Index place;                   // of the first
        std::vector<Index> in_parent;  // for each, its place there
    };

    void forward(const PositionsView& right_hand_sides, Index task, int worker, const Execution& execution,
                 Workspace& workspace) const;
    void backward(Eigen::Ref<Positions>& solution, Index task, int worker, const Execution& execution,
                  Workspace& workspace) const;

    /// What does not depend on the values; factors of one pattern share it.
    struct Analysis {
        SupernodalPattern pattern;
        std::vector<Supernode> supernodes;
        std::vector<Index> below;  // for each supernode where its rows below are in the work vector
        std::vector<EliminationTask> tasks;
        std::vector<UpdateRows> update_rows;
        std::int64_t value_count = 0;  // lanes
        Index row_count = 0;           // of the work vector
        Index most_blocks = 0;         // of a supernode

        Analysis(SupernodalPattern found, const Execution& execution);
        void place_rows(const Execution& execution);
    };

    InstructionSet instructions_;
    std::shared_ptr<const Analysis> analysis_;
    std::unique_ptr<Lanes<Number>[]> values_;
};

/// To be factored once and applied at screen rate, as a preconditioner: one solve is as exact as single precision
/// lets it be, and reads half the memory (docs/decisions/0010-own-cholesky.md).
using SupernodalFactor = CholeskyFactor<float>;
/// To be solved with once or a few times.
using SparseCholesky = CholeskyFactor<double>;

}  // namespace meanvalue
