// Vectors and matrices of four rows at once, for energy_kernels.cpp: always inlined, so that each kernel is made of
// its own processor's instructions.
#pragma once

#include <cmath>
#include <cstdint>

#if defined(__x86_64__)
#include <emmintrin.h>
#endif

#include "meanvalue/decode/fast/energy_kernels.h"

#define MEANVALUE_INLINE inline __attribute__((always_inline))

// Nothing here is ever called, so that it does not matter how its arguments would be passed.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace meanvalue {

using Lane = double __attribute__((vector_size(32), may_alias));
using LaneMask = std::int64_t __attribute__((vector_size(32), may_alias));

MEANVALUE_INLINE Lane lanes(const RowLanes& of) {
    return *reinterpret_cast<const Lane*>(of.value);
}
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

/// Memory as vectors of lanes.
MEANVALUE_INLINE LaneVector* lane_vectors(RowLanes* memory) {
    return reinterpret_cast<LaneVector*>(memory);
}

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

/// One point into each lane.
MEANVALUE_INLINE LaneVector load(const PaddedPoint* points, const Index* which) {
    const auto point = [&](int lane) { return *reinterpret_cast<const Lane*>(points[which[lane]].value); };
    const Lane a = point(0), b = point(1), c = point(2), d = point(3);
    const Lane xz_low = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const Lane y_low = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Lane xz_high = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Lane y_high = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(xz_low, xz_high, 0, 1, 4, 5), __builtin_shufflevector(y_low, y_high, 0, 1, 4, 5),
            __builtin_shufflevector(xz_low, xz_high, 2, 3, 6, 7)};
}

/// Adds each lane to its point, one after another: two may be the same.
MEANVALUE_INLINE void add_to(PaddedPoint* points, const Index* which, const LaneVector& of) {
    const Lane zero{};
    const auto point = [&](int lane) { return reinterpret_cast<Lane*>(points[which[lane]].value); };
    const Lane xy_even = __builtin_shufflevector(of.x, of.y, 0, 4, 2, 6);
    const Lane xy_odd = __builtin_shufflevector(of.x, of.y, 1, 5, 3, 7);
    const Lane z_even = __builtin_shufflevector(of.z, zero, 0, 4, 2, 6);
    const Lane z_odd = __builtin_shufflevector(of.z, zero, 1, 5, 3, 7);
    *point(0) += __builtin_shufflevector(xy_even, z_even, 0, 1, 4, 5);
    *point(1) += __builtin_shufflevector(xy_odd, z_odd, 0, 1, 4, 5);
    *point(2) += __builtin_shufflevector(xy_even, z_even, 2, 3, 6, 7);
    *point(3) += __builtin_shufflevector(xy_odd, z_odd, 2, 3, 6, 7);
}

}  // namespace meanvalue
