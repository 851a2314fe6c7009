#include "meanvalue/encoding/encoder.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/encoding/predictor.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Positions predict_all(const Encoding& encoding, const Positions& vertices) {
    return meanvalue::predict_all(encoding, vertices, 1, Execution());
}

class EveryClass : public testing::TestWithParam<Mesh> {};

TEST_P(EveryClass, PredictGivesTheRestShapeBack) {
    const Mesh& mesh = GetParam();
    const Encoding encoding = encoding_of(mesh);
    EXPECT_LT(largest_distance(predict_all(encoding, mesh.vertices), mesh.vertices), 1e-12 * mesh.diagonal());
}

TEST_P(EveryClass, PredictCommutesWithASimilarity) {
    const Mesh& mesh = GetParam();
    const Encoding encoding = encoding_of(mesh);
    // Of a shape that the encoding does not fit, so that more than the rest shape is tested.
    const Positions bent = with_noise(mesh, 0.05, 7).vertices;
    const auto move = [](const Positions& p) { return moved_by_similarity(p, 2.5, {1, -2, 0.5}, 2.0, {4, 5, -6}); };
    EXPECT_LT(largest_distance(predict_all(encoding, move(bent)), move(predict_all(encoding, bent))),
              1e-10 * mesh.diagonal());
}

TEST_P(EveryClass, WeightsSumToOneAndNothingIsNaN) {
    EXPECT_TRUE(encoding_of(GetParam()).cotangents.empty());  // no solver reads them
    const Encoding encoding = encoding_of(GetParam(), 1, true);
    for (Index v = 0; v < encoding.vertex_count(); ++v) {
        if (!encoding.predictable(v)) continue;
        double sum = 0.0;
        for (Index k = encoding.ring_offsets[v]; k < encoding.ring_offsets[v + 1]; ++k) {
            sum += encoding.weights[k];
            EXPECT_TRUE(std::isfinite(encoding.cotangents[k]));
            EXPECT_TRUE(std::isfinite(encoding.heights[k]));
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
    }
}

TEST_P(EveryClass, IsTheSameForAnyNumberOfThreads) {
    const Encoding one = encoding_of(GetParam(), 1);
    const Encoding three = encoding_of(GetParam(), 3);
    EXPECT_EQ(one.ring, three.ring);
    EXPECT_EQ(one.weights, three.weights);
    EXPECT_EQ(one.heights, three.heights);
    EXPECT_EQ(one.guarded, three.guarded);
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryClass, testing::ValuesIn(all_classes()), [](const auto& info) {
    std::string name = info.param.name + std::to_string(info.index);
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
});

TEST(Encoder, AMirrorImageIsAnotherShape) {
    const Mesh mesh = with_noise(sphere(2), 0.1, 4);
    Positions mirrored = mesh.vertices;
    mirrored.col(0) *= -1.0;
    const double error = largest_distance(predict_all(encoding_of(mesh), mirrored), mirrored);
    EXPECT_GT(error, 1e-3 * mesh.diagonal());
}

TEST(Encoder, IsInvariantUnderASimilarityOfTheMesh) {
    Mesh mesh = with_noise(torus(16, 10), 0.1, 4);
    const Encoding before = encoding_of(mesh, 1, true);
    mesh.vertices = moved_by_similarity(mesh.vertices, 0.3, {1, 1, 0}, 1.0, {1, 2, 3});
    const Encoding after = encoding_of(mesh, 1, true);
    for (std::size_t k = 0; k < before.weights.size(); ++k) {
        EXPECT_NEAR(before.weights[k], after.weights[k], 1e-10);
        EXPECT_NEAR(before.cotangents[k], after.cotangents[k], 1e-10);
    }
}

TEST(Encoder, AStraightBoundaryIsReportedAsOnRingEdge) {
    const auto by_reason = encoding_of(grid(5, 5, 0.0)).guarded_by_reason();
    EXPECT_EQ(by_reason.at("on ring edge").size(), 12u);  // all boundary vertices but the corners
}

TEST(Encoder, TheCornerOfOneTriangleTakesAWiderRing) {
    const Mesh mesh = grid(4, 4, 0.1);
    const Encoding encoding = encoding_of(mesh);
    // Corner 3 (bottom right) is in the one triangle (2, 3, 7).
    EXPECT_EQ(encoding.guarded_by_reason().at("extended ring"), (std::vector<Index>{3, 12}));
    EXPECT_GE(encoding.ring_offsets[4] - encoding.ring_offsets[3], 3);
}

TEST(Encoder, ACollapsedFanGivesShortRings) {
    constexpr Index kRim = 800;
    Mesh mesh;
    mesh.vertices = Positions::Zero(kRim + 3, 3);
    mesh.faces.resize(kRim + 1, 3);
    for (Index k = 0; k < kRim; ++k) {  // all in one line with the vertex that they share
        mesh.vertices(k + 1, 0) = k + 1.0;
        if (k > 0) mesh.faces.row(k - 1) << 0, k, k + 1;
    }
    mesh.vertices.bottomRows(2) << kRim, 5.0, 0.0, kRim, 5.0, 2.0;
    mesh.faces.bottomRows(2) << kRim, kRim + 1, 0, kRim, kRim + 2, kRim + 1;
    const Encoding encoding = encoding_of(mesh);
    EXPECT_TRUE(encoding.predictable(kRim));
    for (Index v = 1; v <= kRim; ++v)
        ASSERT_LE(encoding.ring_offsets[v + 1] - encoding.ring_offsets[v], 128) << v;
}

TEST(Encoder, WhatSpansNoPlaneIsNotPredictableAndKeepsItsPlace) {
    Mesh mesh = joined(triangle(), strip());
    mesh.vertices.conservativeResize(8, 3);
    mesh.vertices.row(7) << 9, 9, 9;
    const Encoding encoding = encoding_of(mesh);
    EXPECT_EQ(encoding.guarded_by_reason().at("not predictable"), (std::vector<Index>{0, 1, 2, 7}));
    const Positions anywhere = Positions::Random(8, 3);
    const Positions predicted = predict_all(encoding, anywhere);
    for (const Index v : {0, 1, 2, 7})
        EXPECT_EQ(predicted.row(v), anywhere.row(v));
    EXPECT_NE(predicted.row(4), anywhere.row(4));
}

TEST(Encoder, AnEdgeAlongTheNormalIsSteepAndStillExact) {
    // A closed fan whose first ring vertex is straight above the middle vertex.
    Mesh mesh;
    mesh.name = "steep";
    mesh.vertices.resize(5, 3);
    mesh.vertices << 0, 0, 0, /**/ 1, 0, 0, /**/ 0, 1, 0, /**/ -1, -1, 0, /**/ 0.3, 0.3, 0;
    const Vector3 normal(0, 0, 1);
    mesh.faces.resize(4, 3);
    mesh.faces << 0, 1, 4, 0, 4, 2, 0, 2, 3, 0, 3, 1;
    for (const double height : {1.0, 30.0, 1e4}) {
        // Shear the ring so that vertex 0 comes to lie under vertex 4 in the ring's own plane.
        mesh.vertices.row(0) = mesh.vertices.row(4) - height * normal.transpose();
        const Encoding encoding = encoding_of(mesh);
        EXPECT_EQ(encoding.guarded_by_reason().at("steep edge"), (std::vector<Index>{0}));
        EXPECT_EQ(encoding.guarded_by_reason().at("on ring vertex"), (std::vector<Index>{0}));
        const Vector3 predicted = predict(encoding.ring_of(0), mesh.vertices);
        EXPECT_LT((predicted - Vector3(mesh.vertices.row(0))).norm(), 1e-12 * mesh.diagonal());
    }
}

TEST(Encoder, FarFromTheOriginNothingIsLostButTheCoordinatesOwnDigits) {
    Mesh mesh = with_noise(sphere(3), 0.1, 1);
    mesh.vertices.rowwise() += Eigen::RowVector3d(1e6, -1e6, 1e6);
    const double error = largest_distance(predict_all(encoding_of(mesh), mesh.vertices), mesh.vertices);
    EXPECT_LT(error, 1e-8);  // coordinates of 1e6 have a spacing of 1e-10
}

}  // namespace
}  // namespace meanvalue::tests
