#include "meanvalue/linalg/supernodal_kernels.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "meanvalue/linalg/simd_lanes.h"

namespace meanvalue {
namespace {

template <typename Number>
struct VectorsOf {
    using Whole __attribute__((vector_size(kLaneBytes), may_alias)) = Number;
    using Four __attribute__((vector_size(4 * sizeof(Number)), may_alias)) = Number;
};
template <typename Number>
using Vector = typename VectorsOf<Number>::Whole;
template <typename Number>
using FourNumbers = typename VectorsOf<Number>::Four;

constexpr int kSides = 3;
constexpr std::ptrdiff_t kPrefetchBytes = 4096;

/// The scratch of a supernode: its rows of the work vector, each right-hand side by itself.
template <typename Number>
struct Sides {
    Vector<Number>* side[kSides];
    Number* number[kSides];

    Sides(Lanes<Number>* scratch, Index blocks) {
        for (int k = 0; k < kSides; ++k) {
            side[k] = reinterpret_cast<Vector<Number>*>(scratch + std::int64_t{k} * blocks);
            number[k] = reinterpret_cast<Number*>(side[k]);
        }
    }
};

/// Asks for the values that will be read `bytes` from here: a group is too short for the processor to see where the
/// reading goes; a quarter of the time at 200,000 columns, whose values are in no cache.
template <int kColumns>
MEANVALUE_INLINE void prefetch(const void* block, std::ptrdiff_t bytes) {
    constexpr int kCacheLine = 64;
    const auto at =
        reinterpret_cast<std::uintptr_t>(block) + bytes;  // may lie outside of the values, which does no harm
    for (int offset = 0; offset < kColumns * static_cast<int>(kLaneBytes); offset += kCacheLine)
        __builtin_prefetch(reinterpret_cast<const void*>(at + offset));  // NOLINT(performance-no-int-to-ptr)
}

/// One group of the forward pass: x = corner^-1 x, then the rows below lose block * x.
template <typename Number, int kColumns>
MEANVALUE_INLINE const Lanes<Number>* forward_group(const Sides<Number>& sides, Index column, Index blocks,
                                                    const Lanes<Number>* values) {
    const auto* corner = reinterpret_cast<const Number*>(values);  // of several lanes
    const Number* below = corner + kGroup;
    Number x[kColumns][kSides];
    for (int c = 0; c < kColumns; ++c) {
        for (int k = 0; k < kSides; ++k)
            x[c][k] = sides.number[k][column + c];
    }
    for (int c = 0; c < kColumns; ++c) {
        for (int k = 0; k < kSides; ++k)
            x[c][k] *= corner[c];
        for (int r = c + 1; r < kColumns; ++r, ++below) {
            for (int k = 0; k < kSides; ++k)
                x[r][k] -= *below * x[c][k];
        }
    }
    for (int c = 0; c < kColumns; ++c) {
        for (int k = 0; k < kSides; ++k)
            sides.number[k][column + c] = x[c][k];
    }
    const auto* block = reinterpret_cast<const Vector<Number>*>(values + kCornerLanes<Number>);
    for (Index b = first_block<Number>(column + kColumns); b < blocks; ++b, block += kColumns) {
        prefetch<kColumns>(block, kPrefetchBytes);
        for (int k = 0; k < kSides; ++k) {
            Vector<Number> sum = sides.side[k][b];
            for (int c = 0; c < kColumns; ++c)
                sum -= block[c] * x[c][k];
            sides.side[k][b] = sum;
        }
    }
    return reinterpret_cast<const Lanes<Number>*>(block);
}

/// The sums over the lanes of four vectors.
template <typename Number>
MEANVALUE_INLINE void sum_lanes(const Vector<Number> (&of)[kGroup], Number (&sums)[kGroup]) {
    using Four = FourNumbers<Number>;
    Four half[kGroup];
    for (int c = 0; c < kGroup; ++c) {
        if constexpr (kLanes<Number> == 8) {
            half[c] =
                __builtin_shufflevector(of[c], of[c], 0, 1, 2, 3) + __builtin_shufflevector(of[c], of[c], 4, 5, 6, 7);
        } else {
            half[c] = of[c];
        }
    }
    const Four a =
        __builtin_shufflevector(half[0], half[1], 0, 4, 1, 5) + __builtin_shufflevector(half[0], half[1], 2, 6, 3, 7);
    const Four b =
        __builtin_shufflevector(half[2], half[3], 0, 4, 1, 5) + __builtin_shufflevector(half[2], half[3], 2, 6, 3, 7);
    const Four total = __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
    std::memcpy(sums, &total, sizeof(sums));
}

/// One group of the backward pass: x loses blocks^T * rows below, then x = corner^-T x.
template <typename Number, int kColumns>
MEANVALUE_INLINE void backward_group(const Sides<Number>& sides, Index column, Index blocks,
                                     const Lanes<Number>* values) {
    Vector<Number> sum[kSides][kGroup] = {};
    const Index first = first_block<Number>(column + kColumns);
    const auto* block = reinterpret_cast<const Vector<Number>*>(values + kCornerLanes<Number>) +
                        std::int64_t{kColumns} * (blocks - first);
    // From the last block to the first: the whole pass then goes through memory in one direction.
    for (Index b = blocks - 1; b >= first; --b) {
        block -= kColumns;
        prefetch<kColumns>(block, -kPrefetchBytes);
        for (int c = 0; c < kColumns; ++c) {
            for (int k = 0; k < kSides; ++k)
                sum[k][c] += block[c] * sides.side[k][b];
        }
    }
    const auto* corner = reinterpret_cast<const Number*>(values);  // of several lanes
    Number x[kSides][kGroup];
    for (int k = 0; k < kSides; ++k)
        sum_lanes<Number>(sum[k], x[k]);
    const Number* below = corner + kGroup + kColumns * (kColumns - 1) / 2;
    for (int c = kColumns - 1; c >= 0; --c) {
        below -= kColumns - 1 - c;
        for (int k = 0; k < kSides; ++k) {
            Number rest = sides.number[k][column + c] - x[k][c];
            for (int r = c + 1; r < kColumns; ++r)
                rest -= below[r - c - 1] * x[k][r];
            x[k][c] = rest * corner[c];
        }
    }
    for (int c = 0; c < kColumns; ++c) {
        for (int k = 0; k < kSides; ++k)
            sides.number[k][column + c] = x[k][c];
    }
}

template <typename Number>
MEANVALUE_INLINE void load_row(const Number* row, const Sides<Number>& sides, Index to) {
    for (int k = 0; k < kSides; ++k)
        sides.number[k][to] = row[k];
}

template <typename Number>
MEANVALUE_INLINE void forward(const Supernode& node, const Lanes<Number>* values, const Index* below,
                              Lanes<Number>* scratch, Number* work) {
    const Index blocks = block_count<Number>(node.row_count);
    const Sides<Number> sides(scratch, blocks);
    Number* own = work + std::int64_t{kStride} * node.first_column;
    for (int k = 0; k < kSides; ++k) {
        for (Index b = node.width / kLanes<Number>; b < blocks; ++b)
            sides.side[k][b] = Vector<Number>{};
    }
    for (Index c = 0; c < node.width; ++c)
        load_row(own + kStride * c, sides, c);
    for (Index column = 0; column < node.width; column += kGroup) {
        values = with_constant(std::min(kGroup, node.width - column), [&](auto columns) MEANVALUE_INLINE_LAMBDA {
            return forward_group<Number, columns>(sides, column, blocks, values);
        });
    }
    for (Index c = 0; c < node.width; ++c) {
        for (int k = 0; k < kSides; ++k)
            own[kStride * c + k] = sides.number[k][c];
    }
    for (Index r = node.width; r < node.row_count; ++r, ++below) {
        Number* row = work + std::int64_t{kStride} * *below;
        for (int k = 0; k < kSides; ++k)
            row[k] += sides.number[k][r];
    }
}

template <typename Number>
MEANVALUE_INLINE void backward(const Supernode& node, const Lanes<Number>* values, const Index* below,
                               Lanes<Number>* scratch, Number* work) {
    const Index blocks = block_count<Number>(node.row_count);
    const Sides<Number> sides(scratch, blocks);
    Number* own = work + std::int64_t{kStride} * node.first_column;
    for (int k = 0; k < kSides; ++k)
        sides.side[k][blocks - 1] = Vector<Number>{};  // the rows that are none, too
    for (Index c = 0; c < node.width; ++c)
        load_row(own + kStride * c, sides, c);
    for (Index r = node.width; r < node.row_count; ++r, ++below)
        load_row(work + std::int64_t{kStride} * *below, sides, r);
    const Lanes<Number>* group = values + lanes_of<Number>(node.width, node.row_count);
    for (Index column = (node.width - 1) / kGroup * kGroup; column >= 0; column -= kGroup) {
        with_constant(std::min(kGroup, node.width - column), [&](auto columns) MEANVALUE_INLINE_LAMBDA {
            group -= kCornerLanes<Number> + std::int64_t{columns} * (blocks - first_block<Number>(column + columns));
            backward_group<Number, columns>(sides, column, blocks, group);
        });
    }
    for (Index c = 0; c < node.width; ++c) {
        for (int k = 0; k < kSides; ++k)
            own[kStride * c + k] = sides.number[k][c];
    }
}

}  // namespace

template <typename Number>
SupernodeKernels<Number> supernode_kernels(InstructionSet instructions) {
    if (use_avx2_and_fma(instructions)) return {WithAvx2<forward<Number>>::call, WithAvx2<backward<Number>>::call};
    return {forward<Number>, backward<Number>};
}

template SupernodeKernels<float> supernode_kernels(InstructionSet);
template SupernodeKernels<double> supernode_kernels(InstructionSet);

}  // namespace meanvalue
