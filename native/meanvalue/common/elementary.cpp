#include "meanvalue/common/elementary.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace meanvalue {
namespace {

constexpr double kPi = 3.14159265358979323846;
// Half of pi, in a part whose products with small whole numbers are exact, and the rest.
constexpr double kHalfPiHigh = 1.57079632673412561417;
constexpr double kHalfPiLow = 6.07710050650619224932e-11;
// From each term of the Taylor series to the next: -1 / (n (n - 1)) and -1 / (n (n + 1)) for n = 2, 4, ... 18.
constexpr int kTerms = 9;
constexpr double kCosineSteps[kTerms] = {-1.0 / 2,   -1.0 / 12,  -1.0 / 30,  -1.0 / 56, -1.0 / 90,
                                         -1.0 / 132, -1.0 / 182, -1.0 / 240, -1.0 / 306};
constexpr double kSineSteps[kTerms] = {-1.0 / 6,   -1.0 / 20,  -1.0 / 42,  -1.0 / 72, -1.0 / 110,
                                       -1.0 / 156, -1.0 / 210, -1.0 / 272, -1.0 / 342};
constexpr double kOddReciprocals[] = {1.0,      1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11, 1.0 / 13,
                                      1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21, 1.0 / 23, 1.0 / 25};
constexpr double kLog2High = 6.93147180369123816490e-01;
constexpr double kLog2Low = 1.90821492927058770002e-10;

/// z + z^3 / 3 + z^5 / 5 ..., or with alternating signs. @param z below 0.2 in size.
double odd_series(double z, double sign) {
    const double square = sign * z * z;
    double sum = 0.0;
    for (int k = 12; k >= 0; --k)
        sum = kOddReciprocals[k] + square * sum;
    return z * sum;
}

}  // namespace

SineCosine sine_cosine(double angle_rad) {
    constexpr double kFarthest = 1e6;
    if (!(std::abs(angle_rad) < kFarthest)) return {std::nan(""), std::nan("")};
    const double quarters = std::floor(angle_rad / (0.5 * kPi) + 0.5);
    const double r = (angle_rad - quarters * kHalfPiHigh) - quarters * kHalfPiLow;
    const double square = r * r;
    double sine = 0.0;
    double cosine = 0.0;
    for (int k = kTerms - 1; k >= 0; --k) {  // Horner's scheme of both Taylor series
        cosine = (1.0 + cosine) * (square * kCosineSteps[k]);
        sine = (1.0 + sine) * (square * kSineSteps[k]);
    }
    sine = r * (1.0 + sine);
    cosine = 1.0 + cosine;
    for (int quarter = static_cast<int>(quarters) & 3; quarter > 0; --quarter) {
        std::swap(sine, cosine);
        cosine = -cosine;
    }
    return {sine, cosine};
}

double arc_tangent(double y, double x) {
    const double high = std::max(std::abs(x), std::abs(y));
    if (high == 0.0) return 0.0;
    double tangent = std::min(std::abs(x), std::abs(y)) / high;
    for (int halving = 0; halving < 2; ++halving)
        tangent /= 1.0 + std::sqrt(1.0 + tangent * tangent);
    double angle = 4.0 * odd_series(tangent, -1.0);
    if (std::abs(y) > std::abs(x)) angle = 0.5 * kPi - angle;
    if (x < 0.0) angle = kPi - angle;
    return y < 0.0 ? -angle : angle;
}

double power(double base, double exponent) {
    int base_two = 0;
    double mantissa = std::frexp(base, &base_two);
    if (mantissa < 0.70710678118654752440) {
        mantissa *= 2.0;
        --base_two;
    }
    const double logarithm =
        base_two * kLog2High + (base_two * kLog2Low + 2.0 * odd_series((mantissa - 1.0) / (mantissa + 1.0), 1.0));
    const double value = exponent * logarithm;
    const double twos = std::floor(value / (kLog2High + kLog2Low) + 0.5);
    const double rest = (value - twos * kLog2High) - twos * kLog2Low;
    double sum = 0.0;
    for (int n = 16; n >= 1; --n)
        sum = (1.0 + sum) * (rest / n);
    return std::ldexp(1.0 + sum, static_cast<int>(twos));
}

}  // namespace meanvalue
