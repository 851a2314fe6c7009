// Elementary functions with the same bits on every processor.
//
// Those of the C library are written several times over for different processors, and round differently. These are
// made of additions, products, divisions and square roots, which IEEE 754 rounds in one way; they are exact to
// 2e-15, power() to 1e-15 times the size of its logarithm.
#pragma once

namespace meanvalue {

struct SineCosine {
    double sine;
    double cosine;
};

/// @param angle_rad between -100 and 100.
SineCosine sine_cosine(double angle_rad);

/// The angle of (x, y), from -pi to pi; 0 for (0, 0).
double arc_tangent(double y, double x);

/// base^exponent, neither too large nor too small for a double. @param base a normal number above 0.
double power(double base, double exponent);

}  // namespace meanvalue
