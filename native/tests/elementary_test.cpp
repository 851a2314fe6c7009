#include "meanvalue/common/elementary.h"

#include <gtest/gtest.h>

#include <cmath>

namespace meanvalue::tests {
namespace {

constexpr double kExact = 2e-15;

TEST(Elementary, SineAndCosine) {
    for (double angle = -99.0; angle < 99.0; angle += 0.0371) {
        const auto [sine, cosine] = sine_cosine(angle);
        EXPECT_NEAR(sine, std::sin(angle), kExact) << angle;
        EXPECT_NEAR(cosine, std::cos(angle), kExact) << angle;
    }
    EXPECT_EQ(sine_cosine(0.0).sine, 0.0);
    EXPECT_EQ(sine_cosine(0.0).cosine, 1.0);
    EXPECT_NEAR(sine_cosine(1e-9).sine, 1e-9, 1e-24);
}

TEST(Elementary, ArcTangentInAllQuadrants) {
    for (double angle = -3.14; angle < 3.14; angle += 0.00731) {
        for (const double length : {1e-150, 0.3, 1.0, 1e150}) {
            const double y = length * std::sin(angle), x = length * std::cos(angle);
            EXPECT_NEAR(arc_tangent(y, x), std::atan2(y, x), kExact) << angle;
        }
    }
    EXPECT_EQ(arc_tangent(0.0, 0.0), 0.0);
    EXPECT_NEAR(arc_tangent(0.0, -1.0), std::acos(-1.0), kExact);
    EXPECT_NEAR(arc_tangent(1e-9, 1.0), 1e-9, 1e-24);
}

TEST(Elementary, Power) {
    for (const double base : {1e-300, 1e-6, 0.3, 0.999, 1.0, 1.001, 70.0, 1e6, 1e300}) {
        for (const double exponent : {-1.0, -0.3, 0.0, 1e-9, 0.5, 0.77, 1.0}) {
            const double expected = std::pow(base, exponent);
            EXPECT_NEAR(power(base, exponent), expected, 4e-13 * expected) << base << " ^ " << exponent;
        }
    }
    EXPECT_EQ(power(70.0, 0.0), 1.0);
}

}  // namespace
}  // namespace meanvalue::tests
