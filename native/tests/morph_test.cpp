// Averages of encodings, rotation vectors beyond half a turn, and what Morpher is made of.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/encoding_blend.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/morph/morpher.h"
#include "meanvalue/morph/rotation_vectors.h"
#include "tests/meshes.h"

namespace meanvalue {
namespace {

struct Shapes {
    Triangles faces;
    std::vector<Positions> positions;

    std::vector<PositionsView> views() const { return {positions.begin(), positions.end()}; }
    std::vector<Encoding> encodings(Execution& execution) const {
        const TriangleMesh mesh(static_cast<Index>(positions[0].rows()), faces, execution);
        return encode_alike(collect_one_rings(mesh, execution), views(), 1, execution);
    }
};

double largest_error(const Encoding& encoding, const Positions& positions) {
    return (predict_all(encoding, positions, 1, Execution()) - positions).rowwise().norm().maxCoeff();
}

TEST(RotationVectors, ComeBackOnTheirBranch) {
    const Vector3 axis = Vector3(1.0, -2.0, 0.5).normalized();
    for (double angle = -9.0; angle < 9.0; angle += 0.37) {
        const Vector3 vector = angle * axis;
        const Matrix3 rotation = rotation_by(vector);
        EXPECT_LT((rotation - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).norm(), 1e-13);
        EXPECT_LT((rotation_vector(rotation, 1.02 * vector) - vector).norm(), 1e-9) << angle;
        EXPECT_LT((rotation_by(rotation_vector(rotation)) - rotation).norm(), 1e-9);
        EXPECT_LE(rotation_vector(rotation).norm(), 3.1416);
    }
    EXPECT_TRUE(rotation_vector(Matrix3::Identity()).isZero(0.0));
    EXPECT_NEAR(rotation_vector(Matrix3::Identity(), 6.0 * axis).norm(), 2.0 * std::acos(-1.0), 1e-12);
}

TEST(Elementary, TangentIsExact) {
    for (double angle = -1.5; angle <= 1.5; angle += 0.01)
        EXPECT_NEAR(tangent(angle), std::tan(angle), 1e-13 * (1.0 + std::abs(std::tan(angle)))) << angle;
}

Shapes noisy_shapes() {
    const tests::Mesh mesh = tests::with_noise(tests::torus(14, 9), 0.1, 1);
    return {mesh.faces,
            {mesh.vertices, tests::with_noise(mesh, 0.2, 2).vertices, tests::with_noise(mesh, 0.2, 3).vertices}};
}

TEST(EncodingBlend, GivesEachShapeBackAndItsRowsSumToOne) {
    const Shapes shapes = noisy_shapes();
    Execution execution;
    const std::vector<Encoding> encodings = shapes.encodings(execution);
    const EncodingBlend blend({&encodings[0], &encodings[1], &encodings[2]}, execution);
    Encoding result = blend.layout();
    for (std::size_t k = 0; k < 3; ++k) {
        std::vector<double> weights(3, 0.0);
        weights[k] = 1.0;
        blend.fill(ShapeWeights(weights, 3, blend.vertex_count()), 1, execution, result);
        EXPECT_LT(largest_error(result, shapes.positions[k]), 1e-10);
    }
    blend.fill(ShapeWeights({0.5, 1.2, -0.7}, 3, blend.vertex_count()), 1, execution, result);
    for (Index v = 0; v < blend.vertex_count(); ++v) {
        const EncodedRing ring = result.ring_of(v);
        double sum = 0.0;
        for (Index k = 0; k < ring.valence; ++k) {
            sum += ring.weights[k];
            EXPECT_TRUE(std::isfinite(ring.heights[k]));
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
    }
}

TEST(EncodingBlend, AGuardedRingOfOneShapeIsGuardedInAll) {
    // A flap of the second shape stands upright: its edges are steep there alone. One of the third has no area.
    const tests::Mesh mesh = tests::grid(7, 7, 0.0);
    Shapes shapes{mesh.faces, {mesh.vertices, mesh.vertices, mesh.vertices}};
    shapes.positions[1].row(24) += Eigen::RowVector3d(0.0, 0.0, 40.0);
    for (const Index v : {15, 16, 17, 18, 22, 23, 25, 26, 30, 31, 32, 33})
        shapes.positions[2].row(v) = shapes.positions[2].row(24);
    Execution execution;
    const std::vector<Encoding> encodings = shapes.encodings(execution);
    EXPECT_FALSE(encodings[0].guarded.empty());
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(encodings[k].guarded, encodings[0].guarded);
        EXPECT_EQ(encodings[k].steep_offset, encodings[0].steep_offset);
        EXPECT_LT(largest_error(encodings[k], shapes.positions[k]), 1e-8);
    }
    EXPECT_NO_THROW(EncodingBlend({&encodings[0], &encodings[1], &encodings[2]}, execution));
    const TriangleMesh alone(49, shapes.faces, execution);
    const Encoding first = encode(collect_one_rings(alone, execution), shapes.positions[0], 1, execution);
    EXPECT_THROW(EncodingBlend({&first, &encodings[1]}, execution), InvalidInput);
}

TEST(Morpher, AGraftIsPlacedWhereAllVerticesAreAnchors) {
    const Shapes shapes = noisy_shapes();
    const auto vertices = static_cast<Index>(shapes.positions[0].rows());
    MorphBinding binding(std::vector<Positions>{shapes.positions[0], shapes.positions[1]}, shapes.faces);
    for (Index v = 0; v < vertices; ++v)
        binding.anchors.push_back(v);
    Execution execution;
    const Morpher morpher(binding, execution);
    const std::vector<double> alike(2 * vertices, 0.5);  // nothing is free, and there is no border to place it by
    EXPECT_TRUE(morpher.solve(alike, {}, execution).vertices.allFinite());
}

TEST(Morpher, PastesAPartWithoutMovingTheRest) {
    // The second shape, turned, moved and twice as large, has a bump on top.
    const tests::Mesh mesh = tests::sphere(4);
    Positions bumped = mesh.vertices;
    std::vector<double> weights(2 * mesh.vertex_count(), 0.0);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const double height = mesh.vertices(v, 2);
        if (height > 0.7) bumped.row(v) *= 1.0 + 3.0 * (height - 0.7);
        const double share = std::min(1.0, std::max(0.0, (height - 0.1) / 0.2));
        weights[v] = 1.0 - share;
        weights[mesh.vertex_count() + v] = share;
    }
    const Positions moved =
        tests::moved_by_similarity(bumped, 2.0, Vector3(1.0, 2.0, 0.3), 1.3, Vector3(7.0, 0.0, -3.0));
    MorphBinding binding(std::vector<Positions>{mesh.vertices, moved}, mesh.faces);
    Execution execution;
    const Morpher morpher(binding, execution);
    const Solution solution = morpher.solve(weights, {}, execution);
    EXPECT_LT((solution.vertices - bumped).rowwise().norm().maxCoeff(), 1e-3 * mesh.diagonal());
}

TEST(Morpher, PartsFollowWithTheBitsOfOneThreadOnSeveral) {
    // A head with an eye, which turns; the eye at its surface goes along.
    tests::Mesh eye = tests::sphere(1);
    eye.vertices = (0.2 * eye.vertices).rowwise() + Eigen::RowVector3d(0.9, 0.2, 0.1);
    const tests::Mesh head = tests::sphere(3);
    const tests::Mesh mesh = tests::joined(head, eye);
    std::vector<Positions> shapes;
    for (const double angle : {0.0, 0.7, 1.4})
        shapes.push_back(tests::moved_by_similarity(mesh.vertices, 1.0, Vector3::UnitZ(), angle, Vector3::Zero()));
    MorphBinding binding(shapes, mesh.faces);
    Execution execution;
    binding.threads = 1;
    const Morpher alone(binding, execution);
    const std::vector<double> weights{0.25, 0.25, 0.5};
    const Positions expected = alone.solve(weights, {}, execution).vertices;
    const double away = (expected.bottomRows(eye.vertex_count()).colwise().mean() -
                         expected.topRows(head.vertex_count()).colwise().mean())
                            .norm();
    EXPECT_NEAR(away, eye.vertices.colwise().mean().norm(), 1e-6);  // round with the head, not straight
    binding.threads = 3;
    const Morpher morpher(binding, execution);
    std::vector<Positions> found(3);
    std::vector<std::thread> callers;
    callers.reserve(found.size());
    for (Positions& result : found)
        callers.emplace_back([&] {
            Execution own;
            result = morpher.solve(weights, {}, own).vertices;
        });
    for (std::thread& caller : callers)
        caller.join();
    for (const Positions& result : found)
        EXPECT_EQ(result, expected);
}

}  // namespace
}  // namespace meanvalue
