// Loads and stores of the energy's coefficients and points as vectors of four lanes.
#pragma once

#include "meanvalue/decode/fast/energy_kernels.h"
#include "meanvalue/linalg/simd_lanes.h"

namespace meanvalue {

static_assert(kRowLanes == kLaneCount, "a row of the energy is a lane");

MEANVALUE_INLINE Lane lanes(const RowLanes& of) {
    return *reinterpret_cast<const Lane*>(of.value);
}

/// Memory as vectors of lanes.
MEANVALUE_INLINE LaneVector* lane_vectors(RowLanes* memory) {
    return reinterpret_cast<LaneVector*>(memory);
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
