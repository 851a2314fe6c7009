// Where the normal matrix of sparse rows has entries.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// The lower triangle of A^T A, of which entry (a, b) is there where a row of A has terms in both columns.
/// @param term_offsets |rows| + 1, term_columns: the columns of each row's terms, in any order, repeated or not.
/// @return for each column the rows at or below it, ascending, the diagonal first; see SymmetricBlocks.
/// @throws Cancelled. Cost: the squares of the rows' lengths.
std::vector<std::vector<Index>> product_pattern(const std::vector<std::int64_t>& term_offsets,
                                                const std::vector<Index>& term_columns, Index column_count,
                                                const Execution& execution);

}  // namespace meanvalue
