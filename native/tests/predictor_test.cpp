#include "meanvalue/encoding/predictor.h"

#include <cmath>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// The largest difference between the closed form and central differences, relative to the largest entry.
double jacobian_error(const Encoding& encoding, Index vertex, Positions positions) {
    const EncodedRing ring = encoding.ring_of(vertex);
    std::vector<Matrix3> blocks(ring.valence);
    const Vector3 value = predict_with_jacobian(ring, positions, blocks.data());
    EXPECT_LT((value - predict(ring, positions)).norm(), 1e-14 * (1.0 + value.norm()));
    constexpr double kStep = 1e-6;
    double error = 0.0;
    double largest = 0.0;
    for (Index k = 0; k < ring.valence; ++k) {
        for (int c = 0; c < 3; ++c) {
            double& coordinate = positions(ring.ring[k], c);
            const double middle = coordinate;
            coordinate = middle + kStep;
            const Vector3 above = predict(ring, positions);
            coordinate = middle - kStep;
            const Vector3 below = predict(ring, positions);
            coordinate = middle;
            error = std::max(error, ((above - below) / (2 * kStep) - blocks[k].col(c)).cwiseAbs().maxCoeff());
            largest = std::max(largest, blocks[k].cwiseAbs().maxCoeff());
        }
    }
    return error / std::max(1.0, largest);
}

class Valence : public testing::TestWithParam<Index> {};

TEST_P(Valence, JacobianAgreesWithCentralDifferences) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Mesh rest = random_fan(GetParam(), seed);
        const Mesh pose = random_fan(GetParam(), seed + 1000);
        const Encoding encoding = encoding_of(rest);
        EXPECT_LT(jacobian_error(encoding, 0, rest.vertices), 1e-7) << "at rest, seed " << seed;
        EXPECT_LT(jacobian_error(encoding, 0, pose.vertices), 1e-7) << "posed, seed " << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(Rings, Valence, testing::Values(3, 4, 5, 6, 7, 9, 13, 30, 75, 200));

TEST(Predictor, JacobianOfASteepRingAgreesWithCentralDifferences) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Mesh rest = random_fan(6, seed);
        rest.vertices.row(0) = rest.vertices.row(2);
        rest.vertices(0, 2) -= 0.8;  // nearly under a ring vertex
        const Encoding encoding = encoding_of(rest);
        if (encoding.ring_of(0).normal_weights == nullptr) continue;
        EXPECT_LT(jacobian_error(encoding, 0, random_fan(6, seed + 1000).vertices), 1e-7) << seed;
    }
}

TEST(Predictor, StaysFiniteOnFoldedAndCollapsedRings) {
    const Mesh rest = random_fan(6, 1);
    const Encoding encoding = encoding_of(rest);
    Positions collapsed = Positions::Zero(7, 3);
    Positions line = rest.vertices;
    line.rightCols(2).setZero();
    Positions folded = rest.vertices;  // the second half retraces the first: no area
    for (int k = 0; k < 3; ++k)
        folded.row(6 - k) = folded.row(k + 1);
    std::vector<Matrix3> blocks(6);
    for (const Positions& pose : {collapsed, line, folded}) {
        EXPECT_TRUE(predict_with_jacobian(encoding.ring_of(0), pose, blocks.data()).allFinite());
        for (const Matrix3& block : blocks)
            EXPECT_TRUE(block.allFinite());
    }
}

TEST(Predictor, GoesOverARingThatFoldsFlatWithoutAJump) {
    // The ring is turned inside out through a state without area, where the paper's normal would jump.
    const Mesh rest = random_fan(6, 3);
    const Encoding encoding = encoding_of(rest);
    constexpr int kSteps = 20000;
    Vector3 before = Vector3::Zero();
    double longest = 0.0;
    for (int step = 0; step <= kSteps; ++step) {
        Positions pose = rest.vertices;
        pose.col(2) *= 0.01;
        pose.col(1) *= 1.0 - 2.0 * step / kSteps;
        const Vector3 predicted = predict(encoding.ring_of(0), pose);
        if (step > 0) longest = std::max(longest, (predicted - before).norm());
        before = predicted;
    }
    const double offset = std::abs(rest.vertices(0, 2));
    EXPECT_GT(offset, 0.1);
    EXPECT_LT(longest, 0.1 * offset);
}

TEST(Energy, IsZeroAtRestAndScalesWithTheSquareOfTheSize) {
    const Mesh mesh = with_noise(sphere(2), 0.1, 1);
    const Encoding encoding = encoding_of(mesh);
    const Execution execution;
    EXPECT_LT(energy(encoding, mesh.vertices, 1, execution), 1e-26);
    const Positions pose = with_noise(mesh, 0.2, 2).vertices;
    const double small = energy(encoding, pose, 1, execution);
    EXPECT_GT(small, 1e-6);
    EXPECT_NEAR(energy(encoding, 3.0 * pose, 1, execution), 9.0 * small, 1e-10 * small);
}

TEST(Energy, SumsHalfTheSquaredResiduals) {
    const Mesh mesh = grid(4, 4, 0.1);
    const Encoding encoding = encoding_of(mesh);
    const Positions pose = with_noise(mesh, 0.2, 2).vertices;
    double expected = 0.0;
    for (Index v = 0; v < 16; ++v) {
        expected += 0.5 * (Vector3(pose.row(v)) - predict(encoding.ring_of(v), pose)).squaredNorm();
    }
    EXPECT_NEAR(energy(encoding, pose, 1, Execution()), expected, 1e-14);
}

}  // namespace
}  // namespace meanvalue::tests
