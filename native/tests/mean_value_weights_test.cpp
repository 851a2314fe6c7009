#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "meanvalue/encoding/ring_encoder.h"

namespace meanvalue::tests {
namespace {

/// A ring in the plane z = 0 around the origin.
ProjectedRing ring_from(const std::vector<Eigen::Vector2d>& points) {
    ProjectedRing ring;
    ring.normal = Vector3::UnitZ();
    for (const Eigen::Vector2d& point : points) {
        ring.tangential.emplace_back(point.x(), point.y(), 0.0);
        ring.radius.push_back(point.norm());
        ring.height.push_back(0.0);
        ring.largest_radius = std::max(ring.largest_radius, point.norm());
    }
    ring.mean_radius =
        std::accumulate(ring.radius.begin(), ring.radius.end(), 0.0) / static_cast<double>(points.size());
    return ring;
}

/// How far the weights are from summing to one and from reproducing the origin.
double error_of(const ProjectedRing& ring, const std::vector<double>& weights) {
    Vector3 point = Vector3::Zero();
    double sum = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        point += weights[k] * ring.tangential[k];
        sum += weights[k];
    }
    return std::max(point.norm(), std::abs(sum - 1.0));
}

double norm_of(const std::vector<double>& weights) {
    return std::sqrt(std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0));
}

TEST(MeanValueWeights, AreUniformOnARegularRing) {
    const ProjectedRing ring = ring_from({{1, 0}, {0, 1}, {-1, 0}, {0, -1}});
    std::vector<double> weights;
    EXPECT_EQ(mean_value_weights(ring, weights), 0);
    for (const double weight : weights)
        EXPECT_NEAR(weight, 0.25, 1e-15);
}

TEST(MeanValueWeights, ReproduceThePointInsideAndOutsideOfThePolygon) {
    std::vector<double> weights;
    for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0.2, 0.1), {0.9, 0.7}, {3.0, 0.5}, {-1.5, -1.5}}) {
        const ProjectedRing ring = ring_from({Eigen::Vector2d(1, 0) - shift, Eigen::Vector2d(1, 1.5) - shift,
                                              Eigen::Vector2d(-0.5, 1) - shift, Eigen::Vector2d(-1, -0.2) - shift,
                                              Eigen::Vector2d(0, -1) - shift});
        EXPECT_EQ(mean_value_weights(ring, weights), 0);
        EXPECT_LT(error_of(ring, weights), 1e-14);
    }
}

TEST(MeanValueWeights, OnAnEdgeInterpolatesBetweenItsEnds) {
    const ProjectedRing ring = ring_from({{1, 0}, {0.5, 2}, {-3, 0}});
    std::vector<double> weights;
    EXPECT_EQ(mean_value_weights(ring, weights), kOnRingEdge);
    EXPECT_DOUBLE_EQ(weights[0], 0.75);
    EXPECT_DOUBLE_EQ(weights[1], 0.0);
    EXPECT_DOUBLE_EQ(weights[2], 0.25);
}

TEST(MeanValueWeights, GoOverContinuouslyIntoTheEdgeRule) {
    std::vector<double> on_edge, near_edge;
    mean_value_weights(ring_from({{1, 0}, {0.5, 2}, {-3, 0}}), on_edge);
    for (const double offset : {1e-4, 1e-7, 1e-8, -1e-7, -1e-4}) {
        const ProjectedRing ring = ring_from({{1, offset}, {0.5, 2 + offset}, {-3, offset}});
        mean_value_weights(ring, near_edge);
        EXPECT_LT(error_of(ring, near_edge), 1e-13) << offset;
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(near_edge[k], on_edge[k], std::abs(offset)) << offset;
    }
}

TEST(MeanValueWeights, OnAVertexTakesItAlone) {
    const ProjectedRing ring = ring_from({{1, 0}, {0, 0}, {-1, -1}});
    std::vector<double> weights;
    EXPECT_EQ(mean_value_weights(ring, weights), kOnRingVertex);
    EXPECT_EQ(weights, (std::vector<double>{0.0, 1.0, 0.0}));
}

TEST(LeastNormWeights, ReproduceThePointOnTangledRingsAndStaySmaller) {
    std::mt19937 random(5);
    std::normal_distribution<double> deviate;
    int exploded = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<Eigen::Vector2d> points(3 + trial % 6);
        for (Eigen::Vector2d& point : points)
            point = {deviate(random), deviate(random)};
        const ProjectedRing ring = ring_from(points);
        std::vector<double> mean_value, least_norm;
        mean_value_weights(ring, mean_value);
        if (weights_are_tame(mean_value)) continue;
        ++exploded;
        least_norm_weights(ring, least_norm);
        EXPECT_LT(error_of(ring, least_norm), 1e-11);
        EXPECT_LE(norm_of(least_norm), norm_of(mean_value) * (1 + 1e-9));
    }
    EXPECT_GT(exploded, 20);  // the rule was in fact exercised
}

TEST(WeightsAreTame, RefusesWhatIsNotANumber) {
    EXPECT_TRUE(weights_are_tame({0.5, 0.5}));
    EXPECT_FALSE(weights_are_tame({3.0, -2.0}));
    EXPECT_FALSE(weights_are_tame({std::nan(""), 1.0}));
}

}  // namespace
}  // namespace meanvalue::tests
