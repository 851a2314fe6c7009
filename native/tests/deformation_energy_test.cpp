#include "meanvalue/decode/fast/deformation_energy.h"

#include <cmath>
#include <random>

#include "meanvalue/encoding/predictor.h"
#include "meanvalue/linalg/procrustes.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr InstructionSet kInstructionSets[] = {InstructionSet::kPortable, InstructionSet::kFastest};

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

/// The energy and its gradient in plain scalar arithmetic, row after row.
class ScalarRows {
  public:
    ScalarRows(const Encoding& encoding, const Unknowns& unknowns, const EnergyBlocks& rows)
        : encoding_(encoding), unknowns_(unknowns), rows_(rows) {}

    Evaluation evaluate(const Positions& pose, double rigidity) const {
        Evaluation result;
        result.gradient.setZero(static_cast<Eigen::Index>(unknowns_.free.size()), 3);
        for (const RowBatch& batch : rows_.batches) {
            for (int lane = 0; lane < kRowLanes; ++lane) {
                if (batch.row[lane] < 0) continue;
                add_bending(batch.row[lane], pose, result);
                if (rigidity > 0.0) add_stretching(batch, lane, pose, rigidity * rows_.stretching, result);
            }
        }
        return result;
    }

  private:
    void add(Index vertex, const Vector3& gradient, Evaluation& result) const {
        if (unknowns_.number[vertex] >= 0) result.gradient.row(unknowns_.number[vertex]) += gradient.transpose();
    }

    void add_bending(Index row, const Positions& pose, Evaluation& result) const {
        const Index centre = unknowns_.rows[row];
        const EncodedRing ring = encoding_.ring_of(centre);
        std::vector<Matrix3> blocks(ring.valence);
        const Vector3 residual = Vector3(pose.row(centre)) - predict_with_jacobian(ring, pose, blocks.data());
        const Vector3 pull = rows_.bending[row] * residual;
        result.energy += 0.5 * pull.dot(residual);
        add(centre, pull, result);
        for (Index k = 0; k < ring.valence; ++k)
            add(ring.ring[k], -blocks[k].transpose() * pull, result);
    }

    void add_stretching(const RowBatch& batch, int lane, const Positions& pose, double factor,
                        Evaluation& result) const {
        const Index centre = unknowns_.rows[batch.row[lane]];
        const EncodedRing ring = encoding_.ring_of(centre);
        // Calls visit(a, b, rest of a - b, weight) for each spoke and rim.
        const auto rest_of = [&](Index k) {
            const EdgeLanes& edge = rows_.edge_lanes[batch.first + k];
            return Vector3(edge.x.value[lane], edge.y.value[lane], edge.z.value[lane]);
        };
        const auto for_each_edge = [&](const auto& visit) {
            for (Index k = 0; k < ring.valence; ++k) {
                const Index next = (k + 1) % ring.valence;
                const StretchingLanes& weights = rows_.stretching_lanes[batch.first + k];
                visit(centre, ring.ring[k], rest_of(k), weights.spoke.value[lane]);
                visit(ring.ring[next], ring.ring[k], Vector3(rest_of(k) - rest_of(next)), weights.rim.value[lane]);
            }
        };
        Matrix3 covariance = Matrix3::Zero();
        for_each_edge([&](Index a, Index b, const Vector3& rest, double weight) {
            covariance += weight * Vector3(pose.row(a) - pose.row(b)) * rest.transpose();
        });
        const Matrix3 rotation = closest_rotation(covariance);
        for_each_edge([&](Index a, Index b, const Vector3& rest, double weight) {
            const Vector3 strain = Vector3(pose.row(a) - pose.row(b)) - rotation * rest;
            const Vector3 pull = factor * weight * strain;
            result.energy += 0.5 * pull.dot(strain);
            add(a, pull, result);
            add(b, -pull, result);
        });
    }

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    const EnergyBlocks& rows_;
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

    DeformationEnergy energy(InstructionSet instructions = InstructionSet::kFastest) const {
        const RestCells cells = rest_cells(encoding_, mesh_.vertices, 1, execution_);
        return {encoding_, unknowns_, cells, mesh_.diagonal(), 1.0, execution_, instructions};
    }

    Evaluation evaluate(const Positions& pose, double rigidity,
                        InstructionSet instructions = InstructionSet::kFastest, int threads = 1) const {
        const DeformationEnergy energy = this->energy(instructions);
        auto workspace = energy.make_workspace();
        Evaluation result;
        result.gradient.setConstant(static_cast<Eigen::Index>(unknowns_.free.size()), 3, std::nan(""));
        result.energy = energy.evaluate(pose, rigidity, result.gradient, threads, execution_, workspace);
        return result;
    }

    Evaluation evaluate_scalar(const Positions& pose, double rigidity) const {
        const RestCells cells = rest_cells(encoding_, mesh_.vertices, 1, execution_);
        const EnergyBlocks rows =
            build_energy_blocks(encoding_, unknowns_, cells, mesh_.diagonal(), 1.0, {}, {}, 1, execution_);
        return ScalarRows(encoding_, unknowns_, rows).evaluate(pose, rigidity);
    }

    /// The kernels against the scalar rows.
    void expect_agreement(const Positions& pose, const std::string& what) const {
        for (const double rigidity : {0.0, 0.5, 30.0}) {
            const Evaluation expected = evaluate_scalar(pose, rigidity);
            EXPECT_GT(expected.energy, 0.0) << what;
            for (const InstructionSet instructions : kInstructionSets) {
                const Evaluation found = evaluate(pose, rigidity, instructions);
                EXPECT_NEAR(found.energy, expected.energy, 1e-12 * expected.energy) << what << ", " << rigidity;
                // Near rest the gradient is a small difference of large numbers, and both round: by their weight,
                // which is up to 70 (an isolated anchor's row).
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
        for (std::size_t number = 0; number < free.size(); number += 1 + free.size() / 10) {
            for (int c = 0; c < 3; ++c) {
                Positions moved = pose;
                moved(free[number], c) = pose(free[number], c) + step;
                const double above = bound.evaluate(moved, rigidity).energy;
                moved(free[number], c) = pose(free[number], c) - step;
                const double below = bound.evaluate(moved, rigidity).energy;
                const auto row = static_cast<Eigen::Index>(number);
                EXPECT_NEAR((above - below) / (2 * step), gradient(row, c), 2e-5 * gradient.cwiseAbs().maxCoeff())
                    << number << ", " << c << ", rigidity " << rigidity;
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
        for (const InstructionSet instructions : kInstructionSets) {
            const Evaluation found = bound.evaluate(pose, 5.0, instructions);
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
        const Evaluation expected = bound.evaluate_scalar(near, rigidity);
        const Evaluation found = bound.evaluate(far, rigidity);
        EXPECT_NEAR(found.energy, expected.energy, 1e-12 * expected.energy);
        EXPECT_LE((found.gradient - expected.gradient).norm(), 1e-12 * expected.gradient.norm());
    }
}

TEST(DeformationEnergy, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(150, 100), 0.2, 1);
    const Bound bound(mesh);
    const Positions pose = bent(mesh);
    for (const InstructionSet instructions : kInstructionSets) {
        const Evaluation one = bound.evaluate(pose, 30.0, instructions, 1);
        for (const int threads : {2, 3, 8}) {
            const Evaluation many = bound.evaluate(pose, 30.0, instructions, threads);
            EXPECT_EQ(many.energy, one.energy);
            EXPECT_EQ(many.gradient, one.gradient);
        }
    }
}

TEST(InitialHessian, IsTheSameForAnyNumberOfThreads) {
    const Bound bound(with_noise(joined(torus(120, 70), steep_fans()), 0.1, 1));
    const Execution execution;
    for (const double rigidity : {0.0, 30.0}) {
        const SparseMatrix one = bound.energy().initial_hessian(rigidity, 1, execution).matrix;
        const SparseMatrix many = bound.energy().initial_hessian(rigidity, 3, execution).matrix;
        ASSERT_EQ(many.nonZeros(), one.nonZeros());
        EXPECT_TRUE(std::equal(one.valuePtr(), one.valuePtr() + one.nonZeros(), many.valuePtr()));
        EXPECT_TRUE(std::equal(one.innerIndexPtr(), one.innerIndexPtr() + one.nonZeros(), many.innerIndexPtr()));
        EXPECT_TRUE(std::equal(one.outerIndexPtr(), one.outerIndexPtr() + one.cols() + 1, many.outerIndexPtr()));
    }
}

TEST(InitialHessian, IsNearTheSecondDerivativeAtRest) {
    // An upper bound but for terms of the bending that it leaves out, and not a loose one.
    const Bound bound(with_noise(sphere(2), 0.2, 1));
    DeformationEnergy energy = bound.energy();
    const Execution execution;
    const SparseMatrix hessian = energy.initial_hessian(50.0, 1, execution).matrix;
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const Positions& rest = bound.mesh().vertices;
    Positions gradient(bound.unknowns().free.size(), 3);
    auto workspace = energy.make_workspace();
    for (int k = 0; k < 5; ++k) {
        Positions moved = rest;
        Positions step(gradient.rows(), 3);
        for (Eigen::Index number = 0; number < step.rows(); ++number) {
            for (int c = 0; c < 3; ++c)
                step(number, c) = 1e-5 * normal(random);
            moved.row(bound.unknowns().free[number]) += step.row(number);
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

TEST(InitialHessian, WithTheFixedVerticesItsRowsSumToZero) {
    // What moves all vertices alike costs nothing: the block of the fixed vertices is the rest of the same matrix.
    const Bound bound(with_noise(joined(torus(30, 20), steep_fans()), 0.3, 1));
    const DeformationEnergy energy = bound.energy();
    const Execution execution;
    for (const double rigidity : {0.0, 15.0}) {
        const auto [hessian, coupling] = energy.initial_hessian(rigidity, 1, execution);
        ASSERT_EQ(coupling.matrix.rows(), hessian.cols());
        ASSERT_EQ(coupling.matrix.cols(), static_cast<Eigen::Index>(coupling.vertices.size()));
        for (const Index v : coupling.vertices)
            EXPECT_LT(bound.unknowns().number[v], 0);
        const Eigen::VectorXd ones = Eigen::VectorXd::Ones(hessian.cols());
        const Eigen::VectorXd own = hessian.selfadjointView<Eigen::Lower>() * ones;
        const Eigen::VectorXd fixed = coupling.matrix * Eigen::VectorXd::Ones(coupling.matrix.cols());
        EXPECT_GT(fixed.norm(), 0.0);
        EXPECT_LT((own + fixed).norm(), 1e-12 * hessian.diagonal().norm());
    }
}

}  // namespace
}  // namespace meanvalue::tests
