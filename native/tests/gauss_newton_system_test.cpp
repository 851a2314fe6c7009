#include "meanvalue/paper/gauss_newton_system.h"

#include <algorithm>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

struct System {
    Mesh mesh;
    Encoding encoding;
    Unknowns unknowns;
    Execution execution;
    Positions pose;

    System() : mesh(with_noise(torus(12, 8), 0.1, 1)), encoding(encoding_of(mesh)) {
        std::vector<char> fixed(mesh.vertex_count(), 0);
        std::fill(fixed.begin(), fixed.begin() + 20, 1);
        unknowns = find_unknowns(encoding, fixed);
        pose = with_noise(mesh, 0.1, 2).vertices;
    }

    double energy_moved(const Eigen::VectorXd& direction, double length) {
        Positions moved = pose;
        for (std::size_t k = 0; k < unknowns.free.size(); ++k) {
            moved.row(unknowns.free[k]) += length * direction.segment<3>(3 * k).transpose();
        }
        return energy(encoding, unknowns, moved, 1, execution);
    }
};

TEST(Unknowns, RowsAreThoseThatDependOnFreeVertices) {
    const Mesh mesh = grid(9, 9, 0.1);
    const Encoding encoding = encoding_of(mesh);
    std::vector<char> fixed(81, 1);
    fixed[40] = 0;
    const Unknowns unknowns = find_unknowns(encoding, fixed);
    EXPECT_EQ(unknowns.free, (std::vector<Index>{40}));
    EXPECT_EQ(unknowns.rows, (std::vector<Index>{30, 31, 39, 40, 41, 49, 50}));  // itself and its ring
}

TEST(GaussNewtonSystem, GradientIsThatOfTheEnergy) {
    System system;
    const GaussNewtonSystem at = linearise(system.encoding, system.unknowns, system.pose, system.execution);
    const Eigen::VectorXd direction = Eigen::VectorXd::Random(at.gradient.size());
    constexpr double kStep = 1e-6;
    const double difference =
        (system.energy_moved(direction, kStep) - system.energy_moved(direction, -kStep)) / (2 * kStep);
    EXPECT_NEAR(difference, at.gradient.dot(direction), 1e-6 * std::abs(difference));
}

TEST(GaussNewtonSystem, MatrixIsTheSecondDerivativeWhereTheResidualIsZero) {
    System system;
    system.pose = system.mesh.vertices;
    const GaussNewtonSystem at = linearise(system.encoding, system.unknowns, system.pose, system.execution);
    const Eigen::VectorXd direction = Eigen::VectorXd::Random(at.gradient.size());
    const Eigen::VectorXd product = at.matrix.selfadjointView<Eigen::Lower>() * direction;
    constexpr double kStep = 1e-4;
    const double difference =
        (system.energy_moved(direction, kStep) + system.energy_moved(direction, -kStep)) / (kStep * kStep);
    EXPECT_NEAR(difference, direction.dot(product), 1e-4 * difference);
}

TEST(GaussNewtonSystem, MetricIsTheMatrixWithoutNormals) {
    // On a flat grid every height is zero, so that H is (I - W)^T (I - W) but for the turning of the normals,
    // which changes nothing within the plane.
    const Mesh mesh = grid(6, 6, 0.0);
    const Encoding encoding = encoding_of(mesh);
    const Unknowns unknowns = find_unknowns(encoding, flags(36, {0, 5, 30}));
    Execution execution;
    const Eigen::MatrixXd with_normals = linearise(encoding, unknowns, mesh.vertices, execution).matrix;
    const Eigen::MatrixXd metric = smoothness_metric(encoding, unknowns, execution);
    for (Eigen::Index row = 0; row < metric.rows(); ++row) {
        for (Eigen::Index column = 0; column <= row; ++column) {
            if (row % 3 == 2 || column % 3 == 2) continue;  // along the normal
            EXPECT_NEAR(metric(row, column), with_normals(row, column), 1e-12);
        }
    }
}

TEST(GaussNewtonSystem, EnergyIsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(90, 60), 0.1, 1);
    const Encoding encoding = encoding_of(mesh);
    const Unknowns unknowns = find_unknowns(encoding, flags(mesh.vertex_count(), {0, 77, 1500}));
    const Execution execution;
    const Positions pose = with_noise(mesh, 0.1, 2).vertices;
    EXPECT_EQ(energy(encoding, unknowns, pose, 1, execution), energy(encoding, unknowns, pose, 4, execution));
}

TEST(GaussNewtonSystem, PatternIsTheSameEverywhereAndTheMetrics) {
    // At rest on a flat grid many blocks are zero; the factor is analyzed once for all of them.
    const Mesh mesh = grid(6, 6, 0.0);
    const Encoding encoding = encoding_of(mesh);
    const Unknowns unknowns = find_unknowns(encoding, flags(36, {0, 5, 30}));
    const Execution execution;
    const SparseMatrix rest = linearise(encoding, unknowns, mesh.vertices, execution).matrix;
    const Positions pose = with_noise(mesh, 0.1, 2).vertices;
    const SparseMatrix moved = linearise(encoding, unknowns, pose, execution).matrix;
    const SparseMatrix metric = smoothness_metric(encoding, unknowns, execution);
    for (const SparseMatrix& other : {moved, metric, SparseMatrix(moved + metric)}) {
        ASSERT_EQ(other.nonZeros(), rest.nonZeros());
        EXPECT_TRUE(std::equal(rest.innerIndexPtr(), rest.innerIndexPtr() + rest.nonZeros(), other.innerIndexPtr()));
    }
}

}  // namespace
}  // namespace meanvalue::tests
