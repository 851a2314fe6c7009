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
        const GaussNewtonSystem equations(encoding, unknowns, execution);
        auto workspace = equations.make_workspace(execution);
        return equations.energy(moved, 1, execution, workspace);
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
    const GaussNewtonSystem equations(system.encoding, system.unknowns, system.execution);
    auto at = equations.make_workspace(system.execution);
    equations.linearise(system.pose, nullptr, 1, system.execution, at);
    const Eigen::VectorXd direction = Eigen::VectorXd::Random(at.gradient.size());
    constexpr double kStep = 1e-6;
    const double difference =
        (system.energy_moved(direction, kStep) - system.energy_moved(direction, -kStep)) / (2 * kStep);
    EXPECT_NEAR(difference, at.gradient.dot(direction), 1e-6 * std::abs(difference));
}

TEST(GaussNewtonSystem, MatrixIsTheSecondDerivativeWhereTheResidualIsZero) {
    System system;
    system.pose = system.mesh.vertices;
    const GaussNewtonSystem equations(system.encoding, system.unknowns, system.execution);
    auto at = equations.make_workspace(system.execution);
    equations.linearise(system.pose, nullptr, 1, system.execution, at);
    const Eigen::VectorXd direction = Eigen::VectorXd::Random(at.gradient.size());
    const Eigen::VectorXd product =
        SparseMatrix(at.matrix.matrix().triangularView<Eigen::Lower>()).selfadjointView<Eigen::Lower>() * direction;
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
    const GaussNewtonSystem equations(encoding, unknowns, execution);
    auto at = equations.make_workspace(execution);
    equations.linearise(mesh.vertices, nullptr, 1, execution, at);
    const Eigen::MatrixXd with_normals = at.matrix.matrix();
    at.matrix.set_zero(execution);
    at.matrix.add_identity_multiples(equations.smoothness_metric(), 1.0);
    const Eigen::MatrixXd metric = at.matrix.matrix();
    for (Eigen::Index row = 0; row < metric.rows(); ++row) {
        for (Eigen::Index column = 0; column <= row; ++column) {
            if (row % 3 == 2 || column % 3 == 2) continue;  // along the normal
            EXPECT_NEAR(metric(row, column), with_normals(row, column), 1e-12);
        }
    }
}

TEST(GaussNewtonSystem, AStepThatFollowsFixedMovesIsExactForATranslation) {
    System system;
    const GaussNewtonSystem equations(system.encoding, system.unknowns, system.execution);
    auto at = equations.make_workspace(system.execution);
    Positions moves = Positions::Zero(system.mesh.vertex_count(), 3);
    for (Index v = 0; v < 20; ++v)
        moves.row(v) << 1, 2, 3;
    equations.linearise(system.mesh.vertices, &moves, 1, system.execution, at);
    const Eigen::VectorXd product =
        SparseMatrix(at.matrix.matrix().triangularView<Eigen::Lower>()).selfadjointView<Eigen::Lower>() *
        Vector3(1, 2, 3).replicate(static_cast<Eigen::Index>(system.unknowns.free.size()), 1);
    EXPECT_LT((product + at.gradient).norm(), 1e-10);
}

TEST(GaussNewtonSystem, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(90, 60), 0.1, 1);
    const Encoding encoding = encoding_of(mesh);
    const Unknowns unknowns = find_unknowns(encoding, flags(mesh.vertex_count(), {0, 77, 1500}));
    Execution execution;
    const GaussNewtonSystem equations(encoding, unknowns, execution);
    auto one = equations.make_workspace(execution);
    auto four = equations.make_workspace(execution);
    const Positions pose = with_noise(mesh, 0.1, 2).vertices;
    equations.linearise(pose, nullptr, 1, execution, one);
    equations.linearise(pose, nullptr, 4, execution, four);
    EXPECT_EQ(one.gradient, four.gradient);
    EXPECT_TRUE(Eigen::Map<const Eigen::VectorXd>(one.matrix.matrix().valuePtr(), one.matrix.matrix().nonZeros()) ==
                Eigen::Map<const Eigen::VectorXd>(four.matrix.matrix().valuePtr(), four.matrix.matrix().nonZeros()));
    EXPECT_EQ(equations.energy(pose, 1, execution, one), equations.energy(pose, 4, execution, four));
}

}  // namespace
}  // namespace meanvalue::tests
