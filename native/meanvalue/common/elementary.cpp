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
constexpr double kLog2High = 6.93147180369123816490e-01;
constexpr double kLog2Low = 1.90821492927058770002e-10;

/// z + z^3 / 3 + z^5 / 5 ..., or with alternating signs. @param z below 0.2 in size.
double odd_series(double z, double sign) {
    const double square = sign * z * z;
    double sum = 0.0;
    for (int n = 25; n >= 1; n -= 2)
        sum = 1.0 / n + square * sum;
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
    for (int n = 18; n >= 2; n -= 2) {  // Horner's scheme of both Taylor series
        cosine = (1.0 + cosine) * (-square / (n * (n - 1)));
        sine = (1.0 + sine) * (-square / (n * (n + 1)));
    }
    sine = r * (1.0 + sine);
    cosine = 1.0 + cosine;
    for (int turn = static_cast<int>(quarters) & 3; turn > 0; --turn) {
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

double angle_order(double y, double x) {
    const double sum = std::abs(x) + std::abs(y);
    if (sum == 0.0) return 0.0;
    const double share = y / sum;
    if (x >= 0.0) return share;
    return y < 0.0 ? -2.0 - share : 2.0 - share;
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
