// The rotations nearest to four matrices at once.
#pragma once

#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/simd_lanes.h"

namespace meanvalue {

/// The lanes named by `ill` again, by singular values. Apart, since it is rare.
__attribute__((noinline)) inline void redo_rotations(const LaneMatrix& matrix, const LaneMask& ill,
                                                     LaneMatrix& rotation) {
    for (int lane = 0; lane < kLaneCount; ++lane) {
        if (ill[lane] == 0) continue;
        const Matrix3 single = lane_of(matrix, lane);
        // Singular values are not defined of what is no number.
        set_lane(single.allFinite() ? fit_rotation(single) : Matrix3::Identity(), lane, rotation);
    }
}

/// Horn's symmetric 4 x 4 matrices, less x I, with the 2 x 2 minors of their upper and their lower two rows:
/// [k00 b c d; b k11 f g; c f k22 i; d g i k33].
struct QuaternionLanes {
    Lane b, c, d, f, g, i;
    Lane k00, k11, k22, k33;
    Lane s0, s1, s2, s3, s4, s5;  // rows 0 and 1
    Lane t1, t2, t3, t4, t5;      // rows 2 and 3; t0 is s5

    MEANVALUE_INLINE QuaternionLanes(const LaneMatrix& m, const Lane& x) {
        const LaneVector &m0 = m.row[0], &m1 = m.row[1], &m2 = m.row[2];
        b = m2.y - m1.z, c = m0.z - m2.x, d = m1.x - m0.y;
        f = m1.x + m0.y, g = m0.z + m2.x, i = m2.y + m1.z;
        k00 = m0.x + m1.y + m2.z - x, k11 = m0.x - m1.y - m2.z - x;
        k22 = m1.y - m0.x - m2.z - x, k33 = m2.z - m0.x - m1.y - x;
        s0 = k00 * k11 - b * b, s1 = k00 * f - b * c, s2 = k00 * g - b * d;
        s3 = b * f - k11 * c, s4 = b * g - k11 * d, s5 = c * g - f * d;
        t5 = k22 * k33 - i * i, t4 = f * k33 - g * i, t3 = f * i - g * k22;
        t2 = c * k33 - d * i, t1 = c * i - d * k22;
    }
};

/// The rotations that maximize trace(R^T M), from the largest eigenvector q of Horn's matrix (1987), a quaternion.
/// The cofactors of K - x I, K that matrix and x its largest eigenvalue, are a multiple of q q^T, and the entries of
/// R are linear in those of q q^T: no column need be chosen. Where the multiple, the product of the gaps between the
/// eigenvalues, is small, digits are lost, and singular values are found instead.
MEANVALUE_INLINE LaneMatrix closest_rotations(const LaneMatrix& matrix) {
    constexpr int kMostSteps = 12;
    constexpr double kStepTolerance = 1e-13;
    // For matrices of norm 1.
    constexpr double kLeastGaps = 1e-2;
    const Lane scale = 1.0 / square_root(dot(matrix.row[0], matrix.row[0]) + dot(matrix.row[1], matrix.row[1]) +
                                         dot(matrix.row[2], matrix.row[2]));
    const LaneMatrix m = {{scale * matrix.row[0], scale * matrix.row[1], scale * matrix.row[2]}};
    // The largest eigenvalue is x = s1 + s2 + s3, s the singular values, the last with the sign of the determinant.
    // x^2 = sum s_i^2 + 2 p and p^2 = sum (s_i s_j)^2 + 2 det x, p = s1 s2 + s2 s3 + s3 s1. Stars of triangles are
    // nearly flat: det is small, so that Newton's method for x is at its end after two or three steps. For the
    // characteristic polynomial, of which x is then nearly a double root, it took more than ten.
    const LaneVector minors = cross(m.row[1], m.row[2]);
    const LaneVector minors_1 = cross(m.row[2], m.row[0]), minors_2 = cross(m.row[0], m.row[1]);
    const Lane squares = dot(m.row[0], m.row[0]) + dot(m.row[1], m.row[1]) + dot(m.row[2], m.row[2]);
    const Lane products = dot(minors, minors) + dot(minors_1, minors_1) + dot(minors_2, minors_2);
    const Lane determinant = dot(m.row[0], minors);
    const Lane zero{};
    Lane x = square_root(squares + 2.0 * square_root(products));
    LaneMask goes_on{};
    for (int step = 0; step < kMostSteps; ++step) {
        const Lane square = products + 2.0 * determinant * x;
        const Lane p = square_root(square > zero ? square : zero);
        const Lane slope = p > zero ? x - determinant / p : x;
        const Lane change = 0.5 * (x * x - squares - 2.0 * p) / slope;
        x -= change;
        // Where p is not positive, as near reflections, this is no root.
        goes_on = ~((change < all_lanes(kStepTolerance)) & (change > all_lanes(-kStepTolerance)) & (p > zero));
        if (!any(goes_on)) break;
    }
    const QuaternionLanes k(m, x);
    // q = (q0, q1, q2, q3), q0 the real part.
    const Lane q00 = k.k11 * k.t5 - k.f * k.t4 + k.g * k.t3;
    const Lane q01 = k.c * k.t4 - k.b * k.t5 - k.d * k.t3;
    const Lane q02 = k.g * k.s5 - k.i * k.s4 + k.k33 * k.s3;
    const Lane q03 = k.k22 * k.s4 - k.f * k.s5 - k.i * k.s3;
    const Lane q11 = k.k00 * k.t5 - k.c * k.t2 + k.d * k.t1;
    const Lane q12 = k.i * k.s2 - k.d * k.s5 - k.k33 * k.s1;
    const Lane q13 = k.c * k.s5 - k.k22 * k.s2 + k.i * k.s1;
    const Lane q22 = k.d * k.s4 - k.g * k.s2 + k.k33 * k.s0;
    const Lane q23 = k.f * k.s2 - k.c * k.s4 - k.i * k.s0;
    const Lane q33 = k.c * k.s3 - k.f * k.s1 + k.k22 * k.s0;
    const Lane gaps = q00 + q11 + q22 + q33;  // times |q|^2 = 1; three negative factors
    const Lane once = 1.0 / gaps;
    const Lane twice = 2.0 * once;
    LaneMatrix rotation = {{{once * (q00 + q11 - q22 - q33), twice * (q12 - q03), twice * (q13 + q02)},
                            {twice * (q12 + q03), once * (q00 - q11 + q22 - q33), twice * (q23 - q01)},
                            {twice * (q13 - q02), twice * (q23 + q01), once * (q00 - q11 - q22 + q33)}}};
    // Written so that lanes without a number are among them.
    const LaneMask ill = ~(gaps < all_lanes(-kLeastGaps)) | goes_on;
    if (any(ill)) redo_rotations(matrix, ill, rotation);
    return rotation;
}

}  // namespace meanvalue
