// A symmetric sparse matrix of 3 x 3 blocks with a fixed pattern, filled anew at each iteration.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/sparse_matrix.h"

namespace meanvalue {

/// The lower triangle, by columns. Blocks on the diagonal are whole: who reads matrix() must ignore what these hold
/// above the diagonal.
class BlockMatrix {
    static constexpr int kSize = 3;

  public:
    BlockMatrix() = default;
    /// @param columns for each block column the block rows at or below it, ascending, the diagonal first.
    /// @throws Cancelled.
    BlockMatrix(const std::vector<std::vector<Index>>& columns, const Execution& execution);

    /// Where block (row, column) is, for add(). @pre row >= column and the block is in the pattern.
    std::int64_t find(Index row, Index column) const;

    /// Until the first call the values are unset. @throws Cancelled.
    void set_zero(const Execution& execution);
    void add(std::int64_t position, Index column, const Matrix3& block) {
        const std::int64_t stride = kSize * (block_start_[column + 1] - block_start_[column]);
        double* entry =
            matrix_.valuePtr() + kSize * kSize * block_start_[column] + kSize * (position - block_start_[column]);
        for (int c = 0; c < kSize; ++c, entry += stride) {
            for (int r = 0; r < kSize; ++r)
                entry[r] += block(r, c);
        }
    }

    /// Adds scale * values[position] * I to every block; @param values one number a block.
    void add_identity_multiples(const std::vector<double>& values, double scale);
    void add_to_diagonal(double amount);

    /// A matrix with the same pattern, its values unset. @throws Cancelled.
    BlockMatrix with_same_pattern(const Execution& execution) const;

    const SparseMatrix& matrix() const { return matrix_; }
    std::int64_t block_count() const { return block_start_.back(); }
    Index block_column_count() const { return static_cast<Index>(block_start_.size()) - 1; }

  private:
    void take_room(const Execution& execution);

    std::vector<std::int64_t> block_start_ = {0};  // per block column, then the total
    std::vector<Index> block_row_;
    SparseMatrix matrix_;
};

}  // namespace meanvalue
