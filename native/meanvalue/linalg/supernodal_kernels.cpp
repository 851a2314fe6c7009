#include "meanvalue/linalg/supernodal_kernels.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define MEANVALUE_INLINE inline __attribute__((always_inline))

namespace meanvalue {
namespace {

using Vector8 = float __attribute__((vector_size(32), may_alias));
using Vector4 = float __attribute__((vector_size(16), may_alias));

constexpr int kSides = 3;
constexpr std::ptrdiff_t kPrefetchBytes = 4096;

/// The scratch of a supernode: its rows of the work vector, each right-hand side by itself.
struct Sides {
    Vector8* side[kSides];
    float* number[kSides];

    Sides(Lanes* scratch, Index blocks) {
        for (int k = 0; k < kSides; ++k) {
            side[k] = reinterpret_cast<Vector8*>(scratch + std::int64_t{k} * blocks);
            number[k] = reinterpret_cast<float*>(side[k]);
        }
    }
};

/// Asks for the values that will be read `bytes` from here: a group is too short for the processor to see where the
/// reading goes; a quarter of the time at 200,000 columns, whose values are in no cache.
template <int kColumns>
MEANVALUE_INLINE void prefetch(const Vector8* block, std::ptrdiff_t bytes) {
    constexpr int kCacheLine = 64;
    const auto at =
        reinterpret_cast<std::uintptr_t>(block) + bytes;  // may lie outside of the values, which does no harm
    for (int offset = 0; offset < kColumns * static_cast<int>(sizeof(Vector8)); offset += kCacheLine)
        __builtin_prefetch(reinterpret_cast<const void*>(at + offset));  // NOLINT(performance-no-int-to-ptr)
}

/// One group of the forward pass: x = corner^-1 x, then the rows below lose block * x.
template <int kColumns>
MEANVALUE_INLINE const Lanes* forward_group(const Sides& sides, Index column, Index blocks, const Lanes* values) {
    const float* corner = values->value;
    const float* below = corner + kGroup;
    float x[kColumns][kSides];
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
    const auto* block = reinterpret_cast<const Vector8*>(values + kCornerLanes);
    for (Index b = first_block(column + kColumns); b < blocks; ++b, block += kColumns) {
        prefetch<kColumns>(block, kPrefetchBytes);
        for (int k = 0; k < kSides; ++k) {
            Vector8 sum = sides.side[k][b];
            for (int c = 0; c < kColumns; ++c)
                sum -= block[c] * x[c][k];
            sides.side[k][b] = sum;
        }
    }
    return reinterpret_cast<const Lanes*>(block);
}

/// The four sums over the lanes of four vectors.
MEANVALUE_INLINE void sum_lanes(const Vector8 (&of)[kGroup], float (&sums)[kGroup]) {
    Vector4 half[kGroup];
    for (int c = 0; c < kGroup; ++c) {
        half[c] =
            __builtin_shufflevector(of[c], of[c], 0, 1, 2, 3) + __builtin_shufflevector(of[c], of[c], 4, 5, 6, 7);
    }
    const Vector4 a =
        __builtin_shufflevector(half[0], half[1], 0, 4, 1, 5) + __builtin_shufflevector(half[0], half[1], 2, 6, 3, 7);
    const Vector4 b =
        __builtin_shufflevector(half[2], half[3], 0, 4, 1, 5) + __builtin_shufflevector(half[2], half[3], 2, 6, 3, 7);
    const Vector4 total = __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
    std::memcpy(sums, &total, sizeof(sums));
}

/// One group of the backward pass: x loses blocks^T * rows below, then x = corner^-T x.
template <int kColumns>
MEANVALUE_INLINE void backward_group(const Sides& sides, Index column, Index blocks, const Lanes* values) {
    Vector8 sum[kSides][kGroup] = {};
    const Index first = first_block(column + kColumns);
    const auto* block =
        reinterpret_cast<const Vector8*>(values + kCornerLanes) + std::int64_t{kColumns} * (blocks - first);
    // From the last block to the first: the whole pass then goes through memory in one direction.
    for (Index b = blocks - 1; b >= first; --b) {
        block -= kColumns;
        prefetch<kColumns>(block, -kPrefetchBytes);
        for (int c = 0; c < kColumns; ++c) {
            for (int k = 0; k < kSides; ++k)
                sum[k][c] += block[c] * sides.side[k][b];
        }
    }
    const float* corner = values->value;
    float x[kSides][kGroup];
    for (int k = 0; k < kSides; ++k)
        sum_lanes(sum[k], x[k]);
    const float* below = corner + kGroup + kColumns * (kColumns - 1) / 2;
    for (int c = kColumns - 1; c >= 0; --c) {
        below -= kColumns - 1 - c;
        for (int k = 0; k < kSides; ++k) {
            float rest = sides.number[k][column + c] - x[k][c];
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

MEANVALUE_INLINE void load_row(const float* row, const Sides& sides, Index to) {
    for (int k = 0; k < kSides; ++k)
        sides.number[k][to] = row[k];
}

MEANVALUE_INLINE void forward(const Supernode& node, const Lanes* values, const Index* below, Lanes* scratch,
                              float* work) {
    const Index blocks = block_count(node.row_count);
    const Sides sides(scratch, blocks);
    float* own = work + std::int64_t{kStride} * node.first_column;
    for (int k = 0; k < kSides; ++k) {
        for (Index b = node.width / kLanes; b < blocks; ++b)
            sides.side[k][b] = Vector8{};
    }
    for (Index c = 0; c < node.width; ++c)
        load_row(own + kStride * c, sides, c);
    Index column = 0;
    for (; column + kGroup <= node.width; column += kGroup)
        values = forward_group<kGroup>(sides, column, blocks, values);
    switch (node.width - column) {
        case 1:
            forward_group<1>(sides, column, blocks, values);
            break;
        case 2:
            forward_group<2>(sides, column, blocks, values);
            break;
        case 3:
            forward_group<3>(sides, column, blocks, values);
            break;
        default:
            break;
    }
    for (Index c = 0; c < node.width; ++c) {
        for (int k = 0; k < kSides; ++k)
            own[kStride * c + k] = sides.number[k][c];
    }
    for (Index r = node.width; r < node.row_count; ++r, ++below) {
        float* row = work + std::int64_t{kStride} * *below;
        for (int k = 0; k < kSides; ++k)
            row[k] += sides.number[k][r];
    }
}

MEANVALUE_INLINE void backward(const Supernode& node, const Lanes* values, const Index* below, Lanes* scratch,
                               float* work) {
    const Index blocks = block_count(node.row_count);
    const Sides sides(scratch, blocks);
    float* own = work + std::int64_t{kStride} * node.first_column;
    for (int k = 0; k < kSides; ++k)
        sides.side[k][blocks - 1] = Vector8{};  // the rows that are none, too
    for (Index c = 0; c < node.width; ++c)
        load_row(own + kStride * c, sides, c);
    for (Index r = node.width; r < node.row_count; ++r, ++below)
        load_row(work + std::int64_t{kStride} * *below, sides, r);
    const Index last = node.width % kGroup;
    const Lanes* end = values + lanes_of(node.width, node.row_count);
    const auto begin_of_group = [&](Index column, Index columns) {
        end -= kCornerLanes + std::int64_t{columns} * (blocks - first_block(column + columns));
        return end;
    };
    Index column = node.width - last;
    switch (last) {
        case 1:
            backward_group<1>(sides, column, blocks, begin_of_group(column, 1));
            break;
        case 2:
            backward_group<2>(sides, column, blocks, begin_of_group(column, 2));
            break;
        case 3:
            backward_group<3>(sides, column, blocks, begin_of_group(column, 3));
            break;
        default:
            break;
    }
    for (column -= kGroup; column >= 0; column -= kGroup)
        backward_group<kGroup>(sides, column, blocks, begin_of_group(column, kGroup));
    for (Index c = 0; c < node.width; ++c) {
        for (int k = 0; k < kSides; ++k)
            own[kStride * c + k] = sides.number[k][c];
    }
}

void forward_portable(const Supernode& node, const Lanes* values, const Index* below, Lanes* scratch, float* work) {
    forward(node, values, below, scratch, work);
}
void backward_portable(const Supernode& node, const Lanes* values, const Index* below, Lanes* scratch, float* work) {
    backward(node, values, below, scratch, work);
}

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void forward_avx2(const Supernode& node, const Lanes* values, const Index* below,
                                                      Lanes* scratch, float* work) {
    forward(node, values, below, scratch, work);
}
__attribute__((target("avx2,fma"))) void backward_avx2(const Supernode& node, const Lanes* values, const Index* below,
                                                       Lanes* scratch, float* work) {
    backward(node, values, below, scratch, work);
}
#endif

}  // namespace

std::int64_t lanes_of(Index width, Index row_count) {
    std::int64_t lanes = 0;
    for (Index column = 0; column < width; column += kGroup) {
        const Index columns = std::min(kGroup, width - column);
        lanes += kCornerLanes + std::int64_t{columns} * (block_count(row_count) - first_block(column + columns));
    }
    return lanes;
}

void pack(const FrontShape& shape, const double* panel, Lanes* values) {
    const Index row_count = shape.width + shape.below;
    const auto entry = [&](Index row, Index column) {
        return panel[shape.place(row) + std::int64_t{column} * kBlockRows];
    };
    for (Index column = 0; column < shape.width; column += kGroup) {
        const Index end = std::min(column + kGroup, shape.width);
        float* corner = values->value;
        std::fill_n(corner, kCornerLanes * kLanes, 0.0F);
        float* below = corner + kGroup;
        for (Index c = column; c < end; ++c) {
            corner[c - column] = static_cast<float>(1.0 / entry(c, c));
            for (Index r = c + 1; r < end; ++r)
                *below++ = static_cast<float>(entry(r, c));
        }
        values += kCornerLanes;
        for (Index row = first_block(end) * kLanes; row < row_count; row += kLanes) {
            const Index first = std::max(row, end);
            const Index behind = std::min(row + kLanes, row_count);
            std::int64_t places[kLanes];
            for (Index r = first; r < behind; ++r)
                places[r - row] = shape.place(r);
            const double* from = panel + std::int64_t{column} * kBlockRows;
            // Mostly the rows are next to one another in the panel, too.
            if (behind - first == kLanes && places[kLanes - 1] == places[0] + kLanes - 1) {
                for (Index c = column; c < end; ++c, ++values, from += kBlockRows) {
                    for (Index lane = 0; lane < kLanes; ++lane)
                        values->value[lane] = static_cast<float>(from[places[0] + lane]);
                }
                continue;
            }
            for (Index c = column; c < end; ++c, ++values, from += kBlockRows) {
                *values = {};
                for (Index lane = first - row; lane < behind - row; ++lane)
                    values->value[lane] = static_cast<float>(from[places[lane]]);
            }
        }
    }
}

SupernodeKernels supernode_kernels([[maybe_unused]] InstructionSet instructions) {
#if defined(__x86_64__)
    if (use_avx2_and_fma(instructions)) return {forward_avx2, backward_avx2};
#endif
    return {forward_portable, backward_portable};
}

#if defined(__x86_64__)
FlushDenormals::FlushDenormals() : before_(_mm_getcsr()) {
    constexpr unsigned kFlushResultsAndOperands = 0x8040;
    _mm_setcsr(before_ | kFlushResultsAndOperands);
}
FlushDenormals::~FlushDenormals() {
    _mm_setcsr(before_);
}
#else
FlushDenormals::FlushDenormals() = default;
FlushDenormals::~FlushDenormals() = default;
#endif

}  // namespace meanvalue
