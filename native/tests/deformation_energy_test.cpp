#include "meanvalue/decode/fast/deformation_energy.h"

#include <cmath>
#include <random>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Kernel = DeformationEnergy::Kernel;

/// A bumpy fan for each valence, far enough apart. @param lift how high the middles are.
Mesh fans(Index fewest, Index most, double lift) {
    Mesh all;
    for (Index valence = fewest; valence <= most; ++valence) {
        Mesh fan = random_fan(valence, valence);
        fan.vertices(0, 2) += lift;
        fan.vertices.col(0).array() += 3.0 * valence;
        all = valence == fewest ? fan : joined(all, fan);
    }
    return all;
}

/// Fans with the middle nearly under a ring vertex: of some the normal offset has weights of its own.
Mesh steep_fans() {
    Mesh mesh = fans(5, 20, 0.0);
    for (Index valence = 5, middle = 0; valence <= 20; middle += valence + 1, ++valence) {
        mesh.vertices.row(middle) = mesh.vertices.row(middle + 2);
        mesh.vertices(middle, 2) -= 0.8;
    }
    return mesh;
}

struct Evaluation {
    double energy = 0.0;
    Positions gradient;
};

/// A mesh at rest, with all that an energy needs. The first vertex of every `fixed_step` is fixed.
class Bound {
  public:
    explicit Bound(const Mesh& mesh, Index fixed_step = 7) : mesh_(mesh), encoding_(encoding_of(mesh)) {
        std::vector<char> is_fixed(mesh.vertex_count(), 0);
        for (Index v = fixed_step / 2; v < mesh.vertex_count(); v += fixed_step)
            is_fixed[v] = 1;
        unknowns_ = find_unknowns(encoding_, is_fixed);
    }

    DeformationEnergy energy(Kernel kernel, double by_length = 1.0) const {
        const RestCells cells = rest_cells(encoding_, mesh_.vertices, 1, execution_);
        return {encoding_, unknowns_, cells, mesh_.diagonal(), by_length, execution_, kernel};
    }

    Evaluation evaluate(const Positions& pose, double rigidity, Kernel kernel = Kernel::kFastest,
                        int threads = 1) const {
        const DeformationEnergy energy = this->energy(kernel);
        auto workspace = energy.make_workspace();
        Evaluation result;
        result.gradient.setConstant(static_cast<Eigen::Index>(unknowns_.free.size()), 3, std::nan(""));
        result.energy = energy.evaluate(pose, rigidity, result.gradient, threads, execution_, workspace);
        return result;
    }

    /// The kernels against the scalar rows.
    void expect_agreement(const Positions& pose, const std::string& what) const {
        for (const double rigidity : {0.0, 0.5, 30.0}) {
            const Evaluation expected = evaluate(pose, rigidity, Kernel::kScalar);
            EXPECT_GT(expected.energy, 0.0) << what;
            for (const Kernel kernel : {Kernel::kPortable, Kernel::kFastest}) {
                const Evaluation found = evaluate(pose, rigidity, kernel);
                EXPECT_NEAR(found.energy, expected.energy, 1e-12 * expected.energy) << what << ", " << rigidity;
                // Near rest the gradient is a small difference of large numbers, and both round: by their weight,
                // which is up to 70 (a lone anchor's row).
                EXPECT_LE((found.gradient - expected.gradient).norm(),
                          1e-12 * expected.gradient.norm() + 70e-15 * mesh_.diagonal())
                    << what << ", " << rigidity;
            }
        }
    }

    const Mesh& mesh() const { return mesh_; }
    const Encoding& encoding() const { return encoding_; }
    const Unknowns& unknowns() const { return unknowns_; }

  private:
    Mesh mesh_;
    Encoding encoding_;
    Unknowns unknowns_;
    Execution execution_;
};

/// Bent about z, the more the farther along y, and noisy.
Positions bent(const Mesh& mesh, unsigned seed = 3) {
    Positions pose = with_noise(mesh, 0.2, seed).vertices;
    const double size = mesh.diagonal();
    for (Eigen::Index v = 0; v < pose.rows(); ++v) {
        const Eigen::AngleAxisd turn(2.0 * pose(v, 1) / size, Vector3(0.0, 0.6, 0.8));
        pose.row(v) = (turn * Vector3(pose.row(v))).transpose();
    }
    return pose;
}

class DeformationEnergyOf : public testing::TestWithParam<Mesh> {};

TEST_P(DeformationEnergyOf, IsThatOfTheScalarRows) {
    const Bound bound(GetParam());
    bound.expect_agreement(bent(GetParam()), "bent");
    bound.expect_agreement(with_noise(GetParam(), 1e-2, 5).vertices, "near rest");
}

TEST_P(DeformationEnergyOf, HasTheGradientOfCentralDifferences) {
    const Bound bound(GetParam());
    const Positions pose = bent(GetParam());
    for (const double rigidity : {0.0, 5.0}) {
        const Positions gradient = bound.evaluate(pose, rigidity).gradient;
        const std::vector<Index>& free = bound.unknowns().free;
        const double step = 1e-6 * bound.mesh().diagonal();
        for (std::size_t slot = 0; slot < free.size(); slot += 1 + free.size() / 10) {
            for (int c = 0; c < 3; ++c) {
                Positions moved = pose;
                moved(free[slot], c) = pose(free[slot], c) + step;
                const double above = bound.evaluate(moved, rigidity).energy;
                moved(free[slot], c) = pose(free[slot], c) - step;
                const double below = bound.evaluate(moved, rigidity).energy;
                const auto row = static_cast<Eigen::Index>(slot);
                EXPECT_NEAR((above - below) / (2 * step), gradient(row, c), 2e-5 * gradient.cwiseAbs().maxCoeff())
                    << slot << ", " << c << ", rigidity " << rigidity;
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, DeformationEnergyOf,
                         testing::Values(with_noise(sphere(3), 0.2, 1), with_noise(torus(40, 31), 0.2, 2),
                                         with_noise(grid(21, 17, 0.02), 0.2, 3),
                                         with_noise(capped_tube(33, 12, 3.0), 0.2, 4),
                                         joined(capped_tube(40, 5, 2.0), sphere(2)), fans(3, 40, 0.2)),
                         [](const auto& info) { return "mesh" + std::to_string(info.index); });

TEST(DeformationEnergy, AgreesOnSteepAndFoldedRings) {
    const Bound steep(joined(steep_fans(), sphere(2)), 1000);
    ASSERT_GT(steep.encoding().steep_weights.size(), 30u);
    steep.expect_agreement(bent(steep.mesh()), "steep");
    const Mesh rest = fans(3, 40, 0.2);
    const Bound bound(rest, 1000);
    Positions folded = rest.vertices;
    for (Eigen::Index v = 0; v < folded.rows(); ++v) {
        folded(v, 1) = std::abs(folded(v, 1));  // the second half of every ring lies on the first
        if (v % 2 == 1) folded(v, 2) *= -1.0;
    }
    bound.expect_agreement(folded, "folded");
    Positions mirrored = rest.vertices;
    mirrored.col(1) *= -1.0;
    bound.expect_agreement(mirrored, "mirrored");
    Positions flat = rest.vertices;
    flat.col(2).setZero();
    bound.expect_agreement(flat, "flat");
}

TEST(DeformationEnergy, StaysFiniteWhereRingsCollapse) {
    const Mesh rest = sphere(2);
    const Bound bound(rest);
    Positions line = rest.vertices;
    line.rightCols(2).setZero();
    for (const Positions& pose : {Positions(Positions::Zero(rest.vertex_count(), 3)), line}) {
        for (const Kernel kernel : {Kernel::kScalar, Kernel::kPortable, Kernel::kFastest}) {
            const Evaluation found = bound.evaluate(pose, 5.0, kernel);
            EXPECT_TRUE(std::isfinite(found.energy));
            EXPECT_TRUE(found.gradient.allFinite());
        }
    }
}

TEST(DeformationEnergy, LosesNothingFarFromTheOrigin) {
    const Mesh mesh = with_noise(sphere(3), 0.2, 1);
    const Bound bound(mesh);
    Positions far = bent(mesh);
    far.rowwise() += Eigen::RowVector3d(1e6, -2e6, 3e6);
    const Positions near = far.rowwise() - Eigen::RowVector3d(1e6, -2e6, 3e6);  // exact
    for (const double rigidity : {0.0, 30.0}) {
        const Evaluation expected = bound.evaluate(near, rigidity, Kernel::kScalar);
        const Evaluation found = bound.evaluate(far, rigidity);
        EXPECT_NEAR(found.energy, expected.energy, 1e-12 * expected.energy);
        EXPECT_LE((found.gradient - expected.gradient).norm(), 1e-12 * expected.gradient.norm());
    }
}

TEST(DeformationEnergy, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(150, 100), 0.2, 1);
    const Bound bound(mesh);
    const Positions pose = bent(mesh);
    for (const Kernel kernel : {Kernel::kScalar, Kernel::kPortable, Kernel::kFastest}) {
        const Evaluation one = bound.evaluate(pose, 30.0, kernel, 1);
        for (const int threads : {2, 3, 8}) {
            const Evaluation many = bound.evaluate(pose, 30.0, kernel, threads);
            EXPECT_EQ(many.energy, one.energy);
            EXPECT_EQ(many.gradient, one.gradient);
        }
    }
}

TEST(ConstantHessian, IsTheSameForAnyNumberOfThreadsAndKernels) {
    const Bound bound(with_noise(joined(torus(120, 70), steep_fans()), 0.1, 1));
    const Execution execution;
    for (const double rigidity : {0.0, 30.0}) {
        const SparseMatrix one = bound.energy(Kernel::kFastest).constant_hessian(rigidity, 1, execution);
        for (const Kernel kernel : {Kernel::kScalar, Kernel::kFastest}) {
            const SparseMatrix many = bound.energy(kernel).constant_hessian(rigidity, 3, execution);
            ASSERT_EQ(many.nonZeros(), one.nonZeros());
            EXPECT_TRUE(std::equal(one.valuePtr(), one.valuePtr() + one.nonZeros(), many.valuePtr()));
            EXPECT_TRUE(std::equal(one.innerIndexPtr(), one.innerIndexPtr() + one.nonZeros(), many.innerIndexPtr()));
            EXPECT_TRUE(std::equal(one.outerIndexPtr(), one.outerIndexPtr() + one.cols() + 1, many.outerIndexPtr()));
        }
    }
}

TEST(ConstantHessian, IsNearTheSecondDerivativeAtRest) {
    // An upper bound but for terms of the bending that it leaves out, and not a loose one.
    const Bound bound(with_noise(sphere(2), 0.2, 1));
    DeformationEnergy energy = bound.energy(Kernel::kFastest);
    const Execution execution;
    const SparseMatrix hessian = energy.constant_hessian(50.0, 1, execution);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const Positions& rest = bound.mesh().vertices;
    Positions gradient(bound.unknowns().free.size(), 3);
    auto workspace = energy.make_workspace();
    for (int k = 0; k < 5; ++k) {
        Positions moved = rest;
        Positions step(gradient.rows(), 3);
        for (Eigen::Index slot = 0; slot < step.rows(); ++slot) {
            for (int c = 0; c < 3; ++c)
                step(slot, c) = 1e-5 * normal(random);
            moved.row(bound.unknowns().free[slot]) += step.row(slot);
        }
        const double found = energy.evaluate(moved, 50.0, gradient, 1, execution, workspace);
        double bending_and_stretching = 0.0;
        for (int c = 0; c < 3; ++c) {
            const Eigen::VectorXd column = step.col(c);
            bending_and_stretching += 0.5 * column.dot(hessian.selfadjointView<Eigen::Lower>() * column);
        }
        EXPECT_GT(found, 0.2 * bending_and_stretching);
        EXPECT_LT(found, 1.5 * bending_and_stretching);
    }
}

TEST(ConstantHessian, WithTheFixedVerticesItsRowsSumToZero) {
    // What moves all vertices alike costs nothing: the block of the fixed vertices is the rest of the same matrix.
    const Bound bound(with_noise(joined(torus(30, 20), steep_fans()), 0.3, 1));
    const DeformationEnergy energy = bound.energy(Kernel::kFastest);
    const Execution execution;
    for (const double rigidity : {0.0, 15.0}) {
        const SparseMatrix hessian = energy.constant_hessian(rigidity, 1, execution);
        const FixedCoupling coupling = energy.fixed_coupling(rigidity, execution);
        ASSERT_EQ(coupling.matrix.rows(), hessian.cols());
        ASSERT_EQ(coupling.matrix.cols(), static_cast<Eigen::Index>(coupling.vertices.size()));
        for (const Index v : coupling.vertices)
            EXPECT_LT(bound.unknowns().slot[v], 0);
        const Eigen::VectorXd ones = Eigen::VectorXd::Ones(hessian.cols());
        const Eigen::VectorXd own = hessian.selfadjointView<Eigen::Lower>() * ones;
        const Eigen::VectorXd fixed = coupling.matrix * Eigen::VectorXd::Ones(coupling.matrix.cols());
        EXPECT_GT(fixed.norm(), 0.0);
        EXPECT_LT((own + fixed).norm(), 1e-12 * hessian.diagonal().norm());
    }
}

}  // namespace
}  // namespace meanvalue::tests
