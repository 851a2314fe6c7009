// The nearest point of a triangle.
#include "meanvalue/mesh/closest_point.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace meanvalue::tests {
namespace {

using Corners = std::array<Vector3, 3>;

Vector3 at(const Corners& corners, const Vector3& weights) {
    return weights(0) * corners[0] + weights(1) * corners[1] + weights(2) * corners[2];
}

/// The least distance to 5151 points of the triangle.
double least_distance(const Corners& corners, const Vector3& point) {
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a <= 100; ++a) {
        for (int b = 0; a + b <= 100; ++b)
            least = std::min(least, (at(corners, Vector3(a, b, 100 - a - b) / 100.0) - point).norm());
    }
    return least;
}

TEST(ClosestPoint, NoOtherPointIsNearer) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    const auto any = [&] { return Vector3(number(random), number(random), number(random)); };
    for (int trial = 0; trial < 300; ++trial) {
        Corners corners{any(), any(), any()};
        if (trial % 5 == 1) corners[2] = 0.3 * corners[0] + 0.7 * corners[1];  // no area but for rounding
        if (trial % 5 == 2) corners[1] = corners[0];
        if (trial % 5 == 3) corners[1] = corners[2] = corners[0];
        const Vector3 point = 1.5 * any();
        const Vector3 weights = closest_point(corners, point);
        EXPECT_GE(weights.minCoeff(), 0.0);
        EXPECT_NEAR(weights.sum(), 1.0, 1e-14);
        const double distance = (at(corners, weights) - point).norm();
        const double least = least_distance(corners, point);
        EXPECT_LE(distance, least + 1e-12);
        EXPECT_NEAR(distance, least, 0.03);
    }
}

TEST(ClosestPoint, OfAPointOfTheTriangleIsThatPoint) {
    const Corners corners{Vector3(0.0, 0.0, 1.0), Vector3(2.0, 0.0, 1.0), Vector3(0.0, 3.0, 1.0)};
    for (const Vector3& weights : {Vector3(0.2, 0.3, 0.5), Vector3(0.5, 0.5, 0.0), Vector3(0.0, 0.0, 1.0)})
        EXPECT_LT((closest_point(corners, at(corners, weights)) - weights).norm(), 1e-15);
}

}  // namespace
}  // namespace meanvalue::tests
