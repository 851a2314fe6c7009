// The dense work of CholeskyFactor: one supernode at a time, three right-hand sides.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Bytes that one vector instruction works on at most; each machine's own vectors are made of it.
constexpr std::size_t kLaneBytes = 32;
template <typename Number>
constexpr Index kLanes = kLaneBytes / sizeof(Number);
template <typename Number>
struct alignas(kLaneBytes) Lanes {
    Number value[kLanes<Number>];
};

/// Columns that are eliminated together: with three right-hand sides their sums fill the sixteen registers.
constexpr Index kGroup = 4;
/// Lanes before the blocks of a group: the reciprocal diagonal, then what is below it, column by column.
template <typename Number>
constexpr Index kCornerLanes = (kGroup * (kGroup + 1) / 2 + kLanes<Number> - 1) / kLanes<Number>;

/// Rows of the work vector are of four numbers, of which three are used: one row is one load.
constexpr Index kStride = 4;

/// A supernode: `width` columns with the same rows, of which the first `width` are the columns themselves.
///
/// Its values are groups of kGroup columns (the last has what is left), each the corner and then blocks of kLanes
/// rows, column after column in each block. The blocks of a group begin with the one that holds the first row below
/// the group; what is not below the group is zero there. So both passes read all values once, in the order of memory.
struct Supernode {
    Index first_column;
    Index width;
    Index row_count;           // with the columns themselves
    std::int64_t first_below;  // in the list of rows: the row_count - width rows below the columns
    std::int64_t values;       // in lanes
};

template <typename Number>
constexpr Index block_count(Index row_count) {
    return (row_count + kLanes<Number> - 1) / kLanes<Number>;
}
/// The block with the first row below the group that ends before column `end`.
template <typename Number>
constexpr Index first_block(Index end) {
    return end / kLanes<Number>;
}
/// Lanes that the values take.
template <typename Number>
constexpr std::int64_t lanes_of(Index width, Index row_count) {
    std::int64_t lanes = 0;
    for (Index column = 0; column < width; column += kGroup) {
        const Index columns = std::min(kGroup, width - column);
        lanes += kCornerLanes<Number> +
                 std::int64_t{columns} * (block_count<Number>(row_count) - first_block<Number>(column + columns));
    }
    return lanes;
}

/// Both substitutions of one supernode.
template <typename Number>
struct SupernodeKernels {
    /// @param values of this supernode. @param below where its rows below are in `work`.
    /// @param scratch 3 * block_count(row_count) lanes. @param work rows of kStride.
    using Kernel = void (*)(const Supernode& supernode, const Lanes<Number>* values, const Index* below,
                            Lanes<Number>* scratch, Number* work);
    Kernel forward;
    Kernel backward;
};
template <typename Number>
SupernodeKernels<Number> supernode_kernels(InstructionSet instructions);

}  // namespace meanvalue
