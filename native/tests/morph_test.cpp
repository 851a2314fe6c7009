// Averages of encodings, rotation vectors beyond half a turn, and what Morpher is made of.
#include <cmath>
#include <numeric>
#include <thread>

#include "meanvalue/encoding/blend.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/morph/cell_assembly.h"
#include "meanvalue/morph/morpher.h"
#include "meanvalue/morph/relative_rotations.h"
#include "meanvalue/morph/rotation_vectors.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

struct Shapes {
    Triangles faces;
    std::vector<Positions> positions;

    std::vector<Encoding> encodings(Execution& execution) const {
        std::vector<Encoding> result;
        result.reserve(positions.size());
        for (const Positions& shape : positions)
            result.push_back(encode(rings_of({"", positions[0], faces}), shape, 1, execution));
        return result;
    }
};

double largest_error(const Encoding& encoding, const Positions& positions) {
    return (predict_all(encoding, positions, 1, Execution()) - positions).rowwise().norm().maxCoeff();
}

TEST(RotationVectors, ComeBackOnTheirBranch) {
    const Vector3 axis = Vector3(1.0, -2.0, 0.5).normalized();
    for (double angle = -9.0; angle < 9.0; angle += 0.37) {
        const Vector3 vector = angle * axis;
        const Quaternion rotation = quaternion_by(vector);
        const Matrix3 matrix = rotation.toRotationMatrix();
        EXPECT_LT((matrix - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).norm(), 1e-13);
        EXPECT_LT((rotation_vector(rotation, 1.02 * vector) - vector).norm(), 1e-9) << angle;
        EXPECT_LT((quaternion_by(rotation_vector(rotation)).toRotationMatrix() - matrix).norm(), 1e-9);
        EXPECT_LE(rotation_vector(rotation).norm(), 3.1416);
    }
    EXPECT_TRUE(rotation_vector(Quaternion::Identity()).isZero(0.0));
    EXPECT_NEAR(rotation_vector(Quaternion::Identity(), 6.0 * axis).norm(), 2.0 * std::acos(-1.0), 1e-12);
}

TEST(CellPatches, VerticesWithoutFacesAreNone) {
    Mesh mesh = grid(40, 40, 0.0);
    const CellPatches alone(rings_of(mesh), Execution());
    mesh.vertices.conservativeResize(20000, 3);
    EXPECT_EQ(CellPatches(rings_of(mesh), Execution()).sizes, alone.sizes);
}

TEST(CellPatches, SharesSumToOneAndAreLargestInTheOwnPatchOfMostVertices) {
    Mesh mesh = with_noise(torus(40, 20), 0.1, 1);
    mesh.vertices.conservativeResize(803, 3);  // the last three have no ring
    mesh.vertices.bottomRows(3).setZero();
    const CellPatches patches(rings_of(mesh), Execution());
    EXPECT_GT(patches.count(), 10);
    EXPECT_EQ(std::accumulate(patches.sizes.begin(), patches.sizes.end(), 0), 800);
    Index own_is_largest = 0;
    for (Index v = 0; v < 800; ++v) {
        double sum = 0.0;
        const CellPatches::Share* largest = nullptr;
        for (const CellPatches::Share& each : patches.shares.of(v)) {
            sum += each.share;
            if (largest == nullptr || each.share > largest->share) largest = &each;
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
        own_is_largest += largest->patch == patches.of[v];
    }
    EXPECT_GT(own_is_largest, 600);
    for (Index v = 800; v < 803; ++v) {
        EXPECT_EQ(patches.of[v], -1);
        EXPECT_TRUE(patches.shares.of(v).empty());
    }
}

TEST(CellAssembly, GivesBackAShapeFromItsEdgesAndTurnsItWithThem) {
    const Mesh mesh = with_noise(torus(30, 16), 0.1, 1);
    const OneRings rings = rings_of(mesh);
    std::vector<Vector3> edges;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (const Index* neighbour = rings.begin(v); neighbour != rings.end(v); ++neighbour)
            edges.emplace_back(mesh.vertices.row(v) - mesh.vertices.row(*neighbour));
    }
    Execution execution;
    const CellAssembly assembly(rings, edges, InstructionSet::kFastest, 1, execution);
    const Quaternion rotation = quaternion_by({1.0, 2.0, -0.5});
    const auto solved = [&](int threads) {
        Positions positions = with_noise(mesh, 0.5, 2).vertices;
        const std::vector<Quaternion> rotations(mesh.vertex_count(), rotation);
        assembly.solve(edges, rotations, threads, execution, positions);
        return positions;
    };
    const Positions found = solved(1);
    EXPECT_EQ(solved(3), found);
    const Positions expected = mesh.vertices * rotation.toRotationMatrix().transpose();
    const Eigen::RowVector3d shift = found.colwise().mean() - expected.colwise().mean();  // stays open
    EXPECT_LT(largest_distance(found.rowwise() - shift, expected), 1e-6 * mesh.diagonal());
}

Shapes noisy_shapes() {
    const Mesh mesh = with_noise(torus(14, 9), 0.1, 1);
    return {mesh.faces, {mesh.vertices, with_noise(mesh, 0.2, 2).vertices, with_noise(mesh, 0.2, 3).vertices}};
}

TEST(Blend, GivesEachShapeBackAndItsRowsSumToOne) {
    const Shapes shapes = noisy_shapes();
    Execution execution;
    const std::vector<Encoding> encodings = shapes.encodings(execution);
    const auto blended = [&](const std::vector<double>& weights) {
        return blend({&encodings[0], &encodings[1], &encodings[2]},
                     ShapeWeights(weights, 3, encodings[0].vertex_count()), 1, execution);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        std::vector<double> weights(3, 0.0);
        weights[k] = 1.0;
        EXPECT_LT(largest_error(blended(weights), shapes.positions[k]), 1e-10);
    }
    const Encoding result = blended({0.5, 1.2, -0.7});
    for (Index v = 0; v < result.vertex_count(); ++v) {
        const EncodedRing ring = result.ring_of(v);
        double sum = 0.0;
        for (Index k = 0; k < ring.valence; ++k) {
            sum += ring.weights[k];
            EXPECT_TRUE(std::isfinite(ring.heights[k]));
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
    }
}

TEST(Blend, ARingThatIsSteepInOneShapeIsSteepInTheBlend) {
    // A flap of the second shape stands upright: its edges are steep there alone.
    const Mesh mesh = grid(7, 7, 0.0);
    Shapes shapes{mesh.faces, {mesh.vertices, mesh.vertices}};
    shapes.positions[1].row(24) += Eigen::RowVector3d(0.0, 0.0, 40.0);
    Execution execution;
    const std::vector<Encoding> encodings = shapes.encodings(execution);
    EXPECT_NE(encodings[0].steep_offset, encodings[1].steep_offset);
    for (std::size_t k = 0; k < 2; ++k) {
        const ShapeWeights weights({k == 0 ? 1.0 : 0.0, k == 0 ? 0.0 : 1.0}, 2, 49);
        const Encoding result = blend({&encodings[0], &encodings[1]}, weights, 1, execution);
        EXPECT_LT(largest_error(result, shapes.positions[k]), 1e-8);
        EXPECT_EQ(result.steep_offset, encodings[1].steep_offset);
    }
}

TEST(Blend, RefusesShapesWithOtherRings) {
    const Mesh mesh = grid(7, 7, 0.0);
    Mesh flat = mesh;  // one ring has no area, and is wider
    for (const Index v : {15, 16, 17, 18, 22, 23, 25, 26, 30, 31, 32, 33})
        flat.vertices.row(v) = flat.vertices.row(24);
    const Encoding first = encoding_of(mesh);
    const Encoding second = encoding_of(flat);
    EXPECT_THROW(blend({&first, &second}, ShapeWeights({1.0, 1.0}, 2, 49), 1, Execution()), InvalidInput);
}

TEST(Morpher, IsInvariantUnderASimilarityOfAllShapesAndTheirOrder) {
    const Shapes shapes = noisy_shapes();
    const auto mixed = [&](const std::vector<Positions>& given, const std::vector<double>& weights) {
        return Morpher(MorphBinding(given, shapes.faces)).solve(weights).vertices;
    };
    const auto moved = [](const Positions& shape) {
        return moved_by_similarity(shape, 2.0, Vector3(1.0, 2.0, 0.3), 1.3, Vector3(7.0, 0.0, -3.0));
    };
    const auto& [first, second, third] = std::tie(shapes.positions[0], shapes.positions[1], shapes.positions[2]);
    const Positions expected = mixed({first, second, third}, {0.5, 0.2, 0.3});
    EXPECT_LT(largest_distance(mixed({third, first, second}, {0.3, 0.5, 0.2}), expected), 1e-5);
    EXPECT_LT(largest_distance(mixed({moved(first), moved(second), moved(third)}, {0.5, 0.2, 0.3}), moved(expected)),
              1e-5);
}

TEST(Morpher, IsCancelledAnywhereAndWorksOn) {
    const Shapes shapes = noisy_shapes();
    MorphBinding binding(shapes.positions, shapes.faces);
    binding.threads = 2;
    std::vector<double> weights(3 * static_cast<std::size_t>(shapes.positions[0].rows()), 0.3);
    weights[7] = 0.9;  // not alike everywhere
    const Positions expected = Morpher(binding).solve(weights).vertices;
    const auto stages = cancelled_everywhere([&](Execution& execution) { Morpher(binding, execution); });
    EXPECT_EQ(stages.back(), "factor");
    const Morpher morpher(binding);
    cancelled_everywhere([&](Execution& execution) { morpher.solve(weights, {}, execution); });
    EXPECT_EQ(morpher.solve(weights).vertices, expected);
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
    const Mesh mesh = sphere(4);
    Positions bumped = mesh.vertices;
    std::vector<double> weights(2 * mesh.vertex_count(), 0.0);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const double height = mesh.vertices(v, 2);
        if (height > 0.7) bumped.row(v) *= 1.0 + 3.0 * (height - 0.7);
        const double share = std::min(1.0, std::max(0.0, (height - 0.1) / 0.2));
        weights[v] = 1.0 - share;
        weights[mesh.vertex_count() + v] = share;
    }
    const Positions moved = moved_by_similarity(bumped, 2.0, Vector3(1.0, 2.0, 0.3), 1.3, Vector3(7.0, 0.0, -3.0));
    MorphBinding binding(std::vector<Positions>{mesh.vertices, moved}, mesh.faces);
    Execution execution;
    const Morpher morpher(binding, execution);
    const Solution solution = morpher.solve(weights, {}, execution);
    EXPECT_LT((solution.vertices - bumped).rowwise().norm().maxCoeff(), 1e-3 * mesh.diagonal());
}

TEST(Morpher, PartsFollowWithTheBitsOfOneThreadOnSeveral) {
    // A head with an eye, which turns; the eye at its surface goes along.
    Mesh eye = sphere(1);
    eye.vertices = (0.2 * eye.vertices).rowwise() + Eigen::RowVector3d(0.9, 0.2, 0.1);
    const Mesh head = sphere(3);
    const Mesh mesh = joined(head, eye);
    std::vector<Positions> shapes;
    for (const double angle : {0.0, 0.7, 1.4})
        shapes.push_back(moved_by_similarity(mesh.vertices, 1.0, Vector3::UnitZ(), angle, Vector3::Zero()));
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
}  // namespace meanvalue::tests
