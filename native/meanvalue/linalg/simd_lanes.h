// Vectors and matrices of three, four of them at once: always inlined, so that each kernel is made of its own
// processor's instructions.
#pragma once

#include <cmath>
#include <cstdint>

#if defined(__x86_64__)
#include <emmintrin.h>
#endif

#include "meanvalue/common/types.h"

#define MEANVALUE_INLINE inline __attribute__((always_inline))
#define MEANVALUE_INLINE_LAMBDA __attribute__((always_inline))
#if defined(__x86_64__)
#define MEANVALUE_AVX2 __attribute__((target("avx2,fma")))
#else
#define MEANVALUE_AVX2  // never called
#endif

// Nothing here is ever called, so that it does not matter how its arguments would be passed.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace meanvalue {

/// Calls action with `count`, 1 to 4, as a constant: for columns that are worked on four at a time, and what is left.
template <typename Action>
MEANVALUE_INLINE auto with_constant(Index count, const Action& action) {
    switch (count) {
        case 1:
            return action(std::integral_constant<Index, 1>());
        case 2:
            return action(std::integral_constant<Index, 2>());
        case 3:
            return action(std::integral_constant<Index, 3>());
        default:
            return action(std::integral_constant<Index, 4>());
    }
}

/// A kernel that is always inlined, made of the instructions of AVX2 and FMA: WithAvx2<kernel>::call.
template <auto kKernel>
struct WithAvx2;
template <typename Result, typename... Arguments, Result (*kKernel)(Arguments...)>
struct WithAvx2<kKernel> {
    MEANVALUE_AVX2 static Result call(Arguments... arguments) { return kKernel(arguments...); }
};

constexpr int kLaneCount = 4;
using Lane = double __attribute__((vector_size(32), may_alias));
using LaneMask = std::int64_t __attribute__((vector_size(32), may_alias));

MEANVALUE_INLINE Lane all_lanes(double value) {
    return Lane{value, value, value, value};
}

MEANVALUE_INLINE Lane square_root(const Lane& of) {
#if defined(__x86_64__)
    // In halves: the instruction for all four is no faster, and not every processor's.
    using Half = double __attribute__((vector_size(16)));
    const Half low = _mm_sqrt_pd(__builtin_shufflevector(of, of, 0, 1));
    const Half high = _mm_sqrt_pd(__builtin_shufflevector(of, of, 2, 3));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3);
#else
    return Lane{std::sqrt(of[0]), std::sqrt(of[1]), std::sqrt(of[2]), std::sqrt(of[3])};
#endif
}

/// 1 / length, and 0 for 0. A length by square_root() is 0 or more than 1e-162, so that this is finite.
MEANVALUE_INLINE Lane inverse_or_zero(const Lane& length) {
    const Lane zero{};
    return length > zero ? 1.0 / length : zero;
}

MEANVALUE_INLINE bool any(const LaneMask& of) {
#if defined(__x86_64__)
    const LaneMask swapped = __builtin_shufflevector(of, of, 2, 3, 0, 1);
    const LaneMask either = of | swapped;
    return _mm_movemask_epi8(reinterpret_cast<const __m128i&>(either)) != 0;
#else
    return ((of[0] | of[1]) | (of[2] | of[3])) != 0;
#endif
}

struct LaneVector {
    Lane x, y, z;
};

MEANVALUE_INLINE LaneVector operator+(const LaneVector& a, const LaneVector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
MEANVALUE_INLINE LaneVector operator-(const LaneVector& a, const LaneVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
MEANVALUE_INLINE LaneVector operator*(const Lane& a, const LaneVector& b) {
    return {a * b.x, a * b.y, a * b.z};
}
MEANVALUE_INLINE void operator+=(LaneVector& a, const LaneVector& b) {
    a.x += b.x;
    a.y += b.y;
    a.z += b.z;
}
MEANVALUE_INLINE Lane dot(const LaneVector& a, const LaneVector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
MEANVALUE_INLINE LaneVector cross(const LaneVector& a, const LaneVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct LaneMatrix {
    LaneVector row[3];

    /// this += a b^T.
    MEANVALUE_INLINE void add_product(const LaneVector& a, const LaneVector& b) {
        row[0] += a.x * b;
        row[1] += a.y * b;
        row[2] += a.z * b;
    }
};

MEANVALUE_INLINE LaneVector operator*(const LaneMatrix& a, const LaneVector& b) {
    return {dot(a.row[0], b), dot(a.row[1], b), dot(a.row[2], b)};
}

/// One of the four.
inline Matrix3 lane_of(const LaneMatrix& matrices, int lane) {
    Matrix3 matrix;
    for (int r = 0; r < 3; ++r)
        matrix.row(r) << matrices.row[r].x[lane], matrices.row[r].y[lane], matrices.row[r].z[lane];
    return matrix;
}
inline void set_lane(const Matrix3& matrix, int lane, LaneMatrix& matrices) {
    for (int r = 0; r < 3; ++r) {
        matrices.row[r].x[lane] = matrix(r, 0);
        matrices.row[r].y[lane] = matrix(r, 1);
        matrices.row[r].z[lane] = matrix(r, 2);
    }
}

}  // namespace meanvalue
