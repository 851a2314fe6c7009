// One row of DeformationEnergy by itself: what its edges count at rest, and its energy in plain scalar arithmetic.
#pragma once

#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// What the second sum of DeformationEnergy needs of one vertex k of a ring of i.
struct Spoke {
    Vector3 rest;  ///< p_i - p_k, in the frame of the cell
    double spoke;  ///< c_ik
    double rim;    ///< c_kl, l the next in the ring
};

/// @param edges `valence` of them, RestCells::edges of i. @param spokes receives as many. @return their mean length.
double measure_spokes(const Vector3* edges, Index valence, Spoke* spokes);

/// What one row gives to the sum.
struct RowEnergy {
    double energy = 0.0;
    Vector3 by_centre = Vector3::Zero();  ///< its derivative by v_i
};

/// The reference of the kernels in energy_kernels.h, and what evaluates the rows that they don't take.
/// @param positions n x 3; @param bending a_i; @param stretching what the second sum is multiplied with, 0: not made.
/// @param by_ring receives `ring.valence` derivatives by the ring's vertices.
RowEnergy evaluate_row(const EncodedRing& ring, Index centre, const PositionsView& positions, const Spoke* spokes,
                       double bending, double stretching, Vector3* by_ring);

}  // namespace meanvalue
