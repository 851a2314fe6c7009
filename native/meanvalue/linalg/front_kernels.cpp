#include "meanvalue/linalg/front_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "meanvalue/linalg/simd_lanes.h"

namespace meanvalue {
namespace {

constexpr Index kStrip = 4;  // columns that are worked on together

/// Rows of a block that are in registers at once: all of it, or a third where registers are of two numbers.
struct WideRows {
    using Vector = double __attribute__((vector_size(32)));
    static constexpr int kVectors = 3;
    static constexpr int kLanes = 4;
};
struct NarrowRows {
    using Vector = double __attribute__((vector_size(16)));
    static constexpr int kVectors = 2;
    static constexpr int kLanes = 2;
};
/// From memory without any alignment. A cast to a vector type of less alignment will not do: Clang forgets it in
/// templates.
template <typename Vector>
MEANVALUE_INLINE Vector load_vector(const double* from) {
    Vector vector;
    std::memcpy(&vector, from, sizeof vector);
    return vector;
}

template <typename R>
constexpr Index row_count() {
    static_assert(kBlockRows % (R::kVectors * R::kLanes) == 0, "a block is whole pieces");
    return R::kVectors * R::kLanes;
}

template <typename R, int kColumns>
struct Tile {
    typename R::Vector at[kColumns][R::kVectors];

    MEANVALUE_INLINE void load(const double* from, std::int64_t stride) {
        for (int c = 0; c < kColumns; ++c) {
            for (int v = 0; v < R::kVectors; ++v)
                at[c][v] = load_vector<typename R::Vector>(from + c * stride + v * R::kLanes);
        }
    }
    MEANVALUE_INLINE void store(double* to, std::int64_t stride) const {
        for (int c = 0; c < kColumns; ++c) {
            for (int v = 0; v < R::kVectors; ++v)
                std::memcpy(to + c * stride + v * R::kLanes, &at[c][v], sizeof at[c][v]);
        }
    }
    /// Loses rows * columns^T, both of `depth` columns of a block.
    MEANVALUE_INLINE void subtract_product(const double* rows, const double* columns, Index depth) {
        typename R::Vector sum[kColumns][R::kVectors] = {};
        for (Index k = 0; k < depth; ++k, rows += kBlockRows, columns += kBlockRows) {
            typename R::Vector row[R::kVectors];
            for (int v = 0; v < R::kVectors; ++v)
                row[v] = load_vector<typename R::Vector>(rows + v * R::kLanes);
            for (int c = 0; c < kColumns; ++c) {
                for (int v = 0; v < R::kVectors; ++v)
                    sum[c][v] += row[v] * columns[c];
            }
        }
        for (int c = 0; c < kColumns; ++c) {
            for (int v = 0; v < R::kVectors; ++v)
                at[c][v] -= sum[c][v];
        }
    }
    /// Times corner^-T. @param corner lower triangle, its columns kBlockRows apart.
    MEANVALUE_INLINE void solve(const double* corner, const double* reciprocals) {
        for (int c = 0; c < kColumns; ++c) {
            for (int v = 0; v < R::kVectors; ++v) {
                for (int before = 0; before < c; ++before)
                    at[c][v] -= at[before][v] * corner[before * kBlockRows + c];
                at[c][v] *= reciprocals[c];
            }
        }
    }
};

/// One strip of a block: what the columns before it take away, then the strip's own corner.
template <typename R, int kColumns, bool kSolve>
MEANVALUE_INLINE void reduce_strip(const double* top_rows, Index column, double* block, const double* corner,
                                   const double* reciprocals) {
    for (Index row = 0; row < kBlockRows; row += row_count<R>()) {
        Tile<R, kColumns> tile;
        double* const at = block + row + std::int64_t{column} * kBlockRows;
        tile.load(at, kBlockRows);
        tile.subtract_product(block + row, top_rows, column);
        if (kSolve) tile.solve(corner, reciprocals + column);
        tile.store(at, kBlockRows);
    }
}

/// @param corner of the columns of a strip; becomes its Cholesky factor.
template <int kColumns>
MEANVALUE_INLINE bool factor_corner(double* corner, double* reciprocals) {
    for (int c = 0; c < kColumns; ++c) {
        double* const column = corner + c * kBlockRows;
        for (int before = 0; before < c; ++before) {
            for (int r = c; r < kColumns; ++r)
                column[r] -= corner[before * kBlockRows + r] * corner[before * kBlockRows + c];
        }
        if (!(column[c] > 0.0) || !std::isfinite(column[c])) return false;
        column[c] = std::sqrt(column[c]);
        reciprocals[c] = 1.0 / column[c];
        for (int r = c + 1; r < kColumns; ++r)
            column[r] *= reciprocals[c];
    }
    return true;
}

/// The strip that begins at `column`, in all top blocks from its own on.
template <typename R, int kColumns>
MEANVALUE_INLINE bool factor_strip(const FrontShape& shape, double* panel, double* reciprocals, Index column) {
    const Index own = column / kBlockRows;
    double* const block = panel + own * shape.block_size();
    const double* const top_rows = block + column % kBlockRows;
    reduce_strip<R, kColumns, false>(top_rows, column, block, nullptr, reciprocals);
    double* const corner = block + std::int64_t{column} * kBlockRows + column % kBlockRows;
    if (!factor_corner<kColumns>(corner, reciprocals + column)) return false;
    // The rows of the block behind the corner.
    for (Index row = column % kBlockRows + kColumns; row < kBlockRows; ++row) {
        double* const of_row = block + std::int64_t{column} * kBlockRows + row;
        for (int c = 0; c < kColumns; ++c) {
            for (int before = 0; before < c; ++before)
                of_row[c * kBlockRows] -= of_row[before * kBlockRows] * corner[before * kBlockRows + c];
            of_row[c * kBlockRows] *= reciprocals[column + c];
        }
    }
    for (Index k = own + 1; k < shape.top_blocks(); ++k)
        reduce_strip<R, kColumns, true>(top_rows, column, panel + k * shape.block_size(), corner, reciprocals);
    return true;
}

template <typename R>
MEANVALUE_INLINE bool factor_top(const FrontShape& shape, double* panel, double* reciprocals) {
    for (Index column = 0; column < shape.width; column += kStrip) {
        const auto factor = [&](auto columns) MEANVALUE_INLINE_LAMBDA {
            return factor_strip<R, columns>(shape, panel, reciprocals, column);
        };
        if (!with_constant(std::min(kStrip, shape.width - column), factor)) return false;
    }
    return true;
}

template <typename R>
MEANVALUE_INLINE void solve_below(const FrontShape& shape, double* panel, const double* reciprocals, Index begin,
                                  Index end) {
    for (Index k = begin; k < end; ++k) {
        double* const block = panel + (shape.top_blocks() + k) * shape.block_size();
        for (Index column = 0; column < shape.width; column += kStrip) {
            const double* const top_rows = panel + (column / kBlockRows) * shape.block_size() + column % kBlockRows;
            const double* const corner = top_rows + std::int64_t{column} * kBlockRows;
            with_constant(std::min(kStrip, shape.width - column), [&](auto columns) MEANVALUE_INLINE_LAMBDA {
                reduce_strip<R, columns, true>(top_rows, column, block, corner, reciprocals);
            });
        }
    }
}

template <typename R>
MEANVALUE_INLINE void update_rest(const FrontShape& shape, const double* panel, double* rest, Index begin,
                                  Index end) {
    const double* const below = panel + shape.top_blocks() * shape.block_size();
    const std::int64_t stride = shape.rest_stride();
    for (Index column = 0; column < end * kBlockRows && column < shape.below; column += kStrip) {
        const double* const columns = below + column / kBlockRows * shape.block_size() + column % kBlockRows;
        for (Index block = std::max(begin, column / kBlockRows); block < end; ++block) {
            for (Index row = 0; row < kBlockRows; row += row_count<R>()) {
                double* const at = rest + column * stride + std::int64_t{block} * kBlockRows + row;
                Tile<R, kStrip> tile;
                tile.load(at, stride);
                tile.subtract_product(below + block * shape.block_size() + row, columns, shape.width);
                tile.store(at, stride);
            }
        }
    }
}

}  // namespace

FrontKernels front_kernels(InstructionSet instructions) {
    if (use_avx2_and_fma(instructions))
        return {WithAvx2<factor_top<WideRows>>::call, WithAvx2<solve_below<WideRows>>::call,
                WithAvx2<update_rest<WideRows>>::call};
    return {factor_top<NarrowRows>, solve_below<NarrowRows>, update_rest<NarrowRows>};
}

}  // namespace meanvalue
