// The dense work of a Cholesky factorisation: one front at a time, double precision.
#pragma once

#include <cstdint>

#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Rows that are worked on together: with four columns their sums fill twelve of sixteen registers.
constexpr Index kBlockRows = 12;

/// A front: the `width` columns that are eliminated, with all rows that these have entries in. The panel, its
/// columns, is in blocks of kBlockRows rows, column after column in each; the rows of the columns themselves come
/// first, and those below begin with a block of their own. What fills up the last block of either is zero.
struct FrontShape {
    Index width = 0;
    Index below = 0;  // rows

    Index top_blocks() const { return (width + kBlockRows - 1) / kBlockRows; }
    Index below_blocks() const { return (below + kBlockRows - 1) / kBlockRows; }
    std::int64_t block_size() const { return std::int64_t{kBlockRows} * width; }
    std::int64_t panel_size() const { return block_size() * (top_blocks() + below_blocks()); }
    /// Rows and columns of the rest, what elimination leaves for the rows below: by columns, lower triangle.
    std::int64_t rest_stride() const { return std::int64_t{kBlockRows} * below_blocks(); }

    /// Where row `row` of column 0 is in the panel; column c is c * kBlockRows further.
    std::int64_t place(Index row) const {
        const Index in_part = row < width ? row : row - width;
        const std::int64_t block = in_part / kBlockRows + (row < width ? 0 : top_blocks());
        return block * block_size() + in_part % kBlockRows;
    }
};

/// In the form for one kind of processor. Sums run in one order in each, however the blocks are shared out.
struct FrontKernels {
    /// The top blocks of the panel become their Cholesky factor; above the diagonal it is undefined.
    /// @param reciprocals of the diagonal, `width` numbers, filled here.
    /// @return false where a pivot is not positive and finite.
    bool (*factor_top)(const FrontShape& shape, double* panel, double* reciprocals);
    /// Blocks [begin, end) of those below become rows of the factor. @pre factor_top().
    void (*solve_below)(const FrontShape& shape, double* panel, const double* reciprocals, Index begin, Index end);
    /// The rest loses the product of the rows below with themselves, in the rows of blocks [begin, end).
    /// @param rest may change anywhere in the blocks on the diagonal. @pre solve_below() for all blocks up to `end`.
    void (*update_rest)(const FrontShape& shape, const double* panel, double* rest, Index begin, Index end);
};

FrontKernels front_kernels(InstructionSet instructions);

}  // namespace meanvalue
