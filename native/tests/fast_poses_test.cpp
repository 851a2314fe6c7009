// The fast method on bends, twists and pulls: how low it ends, and that it ends in one place, however a mesh is
// placed.

#include "tests/fast_poses.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "meanvalue/encoding/predictor.h"

namespace meanvalue::tests {
namespace {

class EveryPlainPose : public testing::TestWithParam<Pose> {};
class EveryPose : public testing::TestWithParam<Pose> {};

TEST_P(EveryPlainPose, WithoutRigidityItReachesTheMinimumOfThePapersEnergy) {
    const Pose& pose = GetParam();
    const Solution fast = solve(*bound_to(pose.mesh, pose.anchors, 0.0), pose.targets);
    const Solution exact = solve(*bound(binding_of(pose.mesh, pose.anchors, Method::kFull, 1)), pose.targets);
    EXPECT_LT(fast.energy, 1.05 * exact.energy);
    const double g = meanvalue::energy(encoding_of(pose.mesh), fast.vertices, 1, Execution());
    EXPECT_NEAR(fast.energy, g, 1e-9 * g);
}

TEST_P(EveryPose, TheSolutionKeepsWhatItPromises) {
    const Pose& pose = GetParam();
    const auto deformer = bound_to(pose.mesh, pose.anchors);
    const Solution solution = solve(*deformer, pose.targets);
    EXPECT_TRUE(solution.converged) << solution.stop_reason;
    EXPECT_TRUE(solution.vertices.allFinite());
    EXPECT_EQ(solution.iterations + 1, static_cast<int>(solution.energies.size()));
    EXPECT_EQ(solution.energies.front(), solution.initial_energy);
    EXPECT_EQ(solution.energies.back(), solution.energy);
    expect_energy_never_rises(solution);
    EXPECT_EQ(rows_of(solution.vertices, pose.anchors), pose.targets);
    const Solution from_there = solve_from(*deformer, pose.targets, solution.vertices);
    EXPECT_LE(from_there.iterations, 10) << "it did not end at its own minimum";
    EXPECT_LT(largest_distance(from_there.vertices, solution.vertices), 2e-3 * pose.mesh.diagonal());
}

TEST_P(EveryPose, AWarmStartEndsWhereAColdSolveEndsOrInAMinimumBesideIt) {
    const Pose& pose = GetParam();
    const auto deformer = bound_to(pose.mesh, pose.anchors);
    const Positions rest = rows_of(pose.mesh.vertices, pose.anchors);
    const Solution near = solve(*deformer, rest + 0.9 * (pose.targets - rest));
    const Solution cold = solve(*deformer, pose.targets);
    const Solution warm = solve_from(*deformer, pose.targets, near.vertices);
    EXPECT_GT(largest_distance(near.vertices, cold.vertices), 1e-2 * pose.mesh.diagonal()) << "no way to go";
    // A sheared shape has several minima of nearly the same energy, and each start ends in its own.
    if (pose.name.find("sheared") != std::string::npos) {
        EXPECT_LT(warm.energy, 1.02 * cold.energy);
        for (const Solution& solution : {cold, warm}) {
            const Solution farther = solve_from(*deformer, pose.targets, solution.vertices, {1e-7, 5000});
            EXPECT_GT(farther.energy, 0.998 * solution.energy);
        }
        return;
    }
    EXPECT_LT(warm.energy, 1.005 * cold.energy);
    // Each stops near the minimum; it is the same one.
    const Solution below_cold = solve_from(*deformer, pose.targets, cold.vertices, {1e-8, 5000});
    const Solution below_warm = solve_from(*deformer, pose.targets, warm.vertices, {1e-8, 5000});
    EXPECT_LT(largest_distance(below_cold.vertices, below_warm.vertices), 1e-5 * pose.mesh.diagonal());
    EXPECT_LT(largest_distance(below_cold.vertices, cold.vertices), 2e-3 * pose.mesh.diagonal());
    EXPECT_LT(largest_distance(below_warm.vertices, warm.vertices), 1e-3 * pose.mesh.diagonal());
}

INSTANTIATE_TEST_SUITE_P(Poses, EveryPlainPose, testing::ValuesIn(plain_poses()));
INSTANTIATE_TEST_SUITE_P(Poses, EveryPose, testing::ValuesIn(poses()));

TEST(FastDecoder, WithoutRigidityALongThinTubeIsBentToTheMinimum) {
    const Pose pose = poses().back();
    const auto deformer = bound_to(pose.mesh, pose.anchors, 0.0);
    const Solution solution = solve(*deformer, pose.targets);
    EXPECT_TRUE(solution.converged);
    EXPECT_LT(solution.energy, 1.05 * solve(*deformer, pose.targets, {1e-5, 2000}).energy);
}

/// A ball with sharp tips and slivers, as models have at ears, nails and folds, and nine single vertices as anchors.
Mesh spiky_ball() {
    Mesh mesh = with_noise(sphere(5), 0.2, 3);
    for (const Index v : spread_vertices(mesh, 60))
        mesh.vertices.row(v) *= 1.03;
    return mesh;
}

TEST(FastDecoder, ADraggedLoneAnchorIsFollowedInFewStepsHoweverSharpTheShapeIs) {
    const Mesh mesh = spiky_ball();
    const std::vector<Index> anchors = spread_vertices(mesh, 9);
    const auto deformer = bound_to(mesh, anchors);
    const Positions rest = rows_of(mesh.vertices, anchors);
    Deformer::Drag drag(*deformer, PositionsView(mesh.vertices));
    std::vector<int> iterations;
    Solution last;
    Positions targets = rest;
    for (int frame = 1; frame <= 20; ++frame) {
        targets.row(0) = rest.row(0) + frame * 0.0075 * mesh.diagonal() * Eigen::RowVector3d(0.6, 0.8, 0);
        last = solve_next(drag, targets);
        EXPECT_TRUE(last.converged) << frame;
        iterations.push_back(last.iterations);
    }
    EXPECT_LE(*std::max_element(iterations.begin(), iterations.end()), 10);
    EXPECT_LE(std::accumulate(iterations.begin(), iterations.end(), 0), 90);
    EXPECT_LT(last.energy, 1.02 * solve(*deformer, targets).energy);
}

TEST(FastDecoder, AStartThatIsNoSolutionCostsNoMoreThanOneFromRestAndEndsAsLow) {
    const Mesh mesh = spiky_ball();
    const std::vector<Index> anchors = spread_vertices(mesh, 9);
    const auto deformer = bound_to(mesh, anchors);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(0) *= 1.2;
    const Solution cold = solve(*deformer, targets);
    EXPECT_GT(cold.all_iterations, cold.iterations);
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0.0, 0.01 * mesh.diagonal());
    Positions noisy = mesh.vertices;
    for (const Index v : anchors) {
        for (int c = 0; c < 3; ++c)
            noisy(v, c) += normal(random);
    }
    const Solution found = solve_from(*deformer, targets, noisy);
    EXPECT_TRUE(found.converged);
    expect_energy_never_rises(found);
    EXPECT_LT(found.energy, 1.02 * cold.energy);
    EXPECT_LE(found.all_iterations, 2 * cold.all_iterations + 120);
}

TEST(FastDecoder, RigidityGoesToZeroWithoutAJump) {
    const Mesh mesh = with_noise(torus(40, 20), 0.2, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 10);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) *= 1.2;
    const SolveOptions fine{1e-8, 5000};
    const Positions without = solve(*bound_to(mesh, anchors, 0.0), targets, fine).vertices;
    const Positions hardly = solve(*bound_to(mesh, anchors, 1e-6), targets, fine).vertices;
    EXPECT_LT(largest_distance(hardly, without), 1e-3 * mesh.diagonal());
    EXPECT_GT(largest_distance(solve(*bound_to(mesh, anchors, 1.0), targets, fine).vertices, without),
              2e-3 * mesh.diagonal());
}

TEST(FastDecoder, AStartIsAStartAndNothingElse) {
    const Pose pose = two_ends("", bar(6, 36), Vector3::UnitZ(), 0.8, {0, 0.3, 0});
    const Positions rest = rows_of(pose.mesh.vertices, pose.anchors);
    const auto between = [&](double share) { return Positions(rest + share * (pose.targets - rest)); };
    const auto deformer = bound_to(pose.mesh, pose.anchors);
    Positions shape = pose.mesh.vertices;
    for (const double share : {0.1, 0.2, 0.3})
        shape = solve_from(*deformer, between(share), shape).vertices;
    {
        Deformer::Drag drag(*deformer, PositionsView(pose.mesh.vertices));
        for (const double share : {0.1, 0.2, 0.3})
            solve_next(drag, between(share));
    }
    const Solution here = solve_from(*deformer, between(0.4), shape);
    const Solution fresh = solve_from(*bound_to(pose.mesh, pose.anchors), between(0.4), shape);
    EXPECT_EQ(here.vertices, fresh.vertices);
    EXPECT_EQ(here.energies, fresh.energies);
}

TEST(FastDecoder, ADragOfStiffSoftAnchorsTakesNoMoreStepsThanOneOfHardOnes) {
    const Pose pose = two_ends("", bar(6, 36), Vector3::UnitZ(), 0.8, {0, 0.3, 0});
    const Positions rest = rows_of(pose.mesh.vertices, pose.anchors);
    const auto iterations_of_drag = [&](double strength) {
        Binding binding = binding_of(pose.mesh, pose.anchors, Method::kFast, 1);
        binding.strengths.assign(pose.anchors.size(), strength);
        const auto deformer = bound(binding);
        Deformer::Drag drag(*deformer, PositionsView(pose.mesh.vertices));
        int iterations = 0;
        for (int frame = 1; frame <= 12; ++frame) {
            const Solution solution = solve_next(drag, rest + frame / 24.0 * (pose.targets - rest));
            EXPECT_TRUE(solution.converged) << strength << " " << frame;
            iterations += solution.iterations;
        }
        return iterations;
    };
    const int hard = iterations_of_drag(std::numeric_limits<double>::infinity());
    for (const double strength : {1e2, 1e4, 1e6, 1e9})
        EXPECT_LE(iterations_of_drag(strength), 2 * hard) << strength;
}

TEST(FastDecoder, AnUnsteadyDragEndsWhereASteadyOneDoes) {
    const Mesh mesh = bar(6, 36);
    const auto at = [&](double angle, double x, double y) {
        return two_ends("", mesh, Vector3::UnitX(), angle, {x, y, -0.1});
    };
    const auto deformer = bound_to(mesh, at(0, 0, 0).anchors);
    Deformer::Drag drag(*deformer, PositionsView(mesh.vertices));
    Solution last;
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, 0.25);
    Positions targets;
    for (int frame = 1; frame <= 30; ++frame) {
        // Far and near, to and fro, and now and then not at all.
        const double jerk = frame % 7 == 0 ? 4.0 : 1.0;
        if (frame % 5 != 0) targets = at(0.4 + jerk * noise(random), jerk * noise(random), noise(random)).targets;
        last = solve_next(drag, targets);
        EXPECT_TRUE(last.converged) << frame;
        EXPECT_LE(last.iterations, 60) << frame;
        EXPECT_LT(last.energy, 1.02 * solve(*deformer, targets).energy) << frame;
    }
}

// Twisted farther than half a turn by dragging; from rest, the other way about is nearer.
TEST(FastDecoder, SettlingKeepsTheBetterOfWarmAndCold) {
    const Mesh mesh = bar(6, 36);
    const auto turned = [&](double degrees) {
        return two_ends("", mesh, Vector3::UnitZ(), degrees * (kPi / 180.0), Vector3::Zero());
    };
    const Pose pose = turned(240.0);
    const auto deformer = bound_to(pose.mesh, pose.anchors);
    Positions dragged = pose.mesh.vertices;
    {
        Deformer::Drag drag(*deformer, PositionsView(dragged));
        for (int degrees = 20; degrees < 240; degrees += 20)
            dragged = solve_next(drag, turned(degrees).targets).vertices;
    }
    SolveOptions options;
    options.settle = true;
    const Solution cold = solve(*deformer, pose.targets, options);
    const Solution warm = solve_from(*deformer, pose.targets, dragged);
    const Solution settled = solve_from(*deformer, pose.targets, dragged, options);
    EXPECT_GT(largest_distance(warm.vertices, cold.vertices), 0.05 * pose.mesh.diagonal()) << "nothing to choose";
    EXPECT_LT(cold.energy, warm.energy);
    EXPECT_EQ(settled.energy, cold.energy);
    EXPECT_EQ(settled.vertices, cold.vertices);
    // Where the other one is better.
    const Pose less = turned(100.0);
    const Solution near = solve(*deformer, less.targets);
    const Solution exact = solve_from(*deformer, less.targets, near.vertices, options);
    EXPECT_LE(exact.energy, near.energy);
}

TEST(FastDecoder, AHandleThatMovesWithEverythingIsFollowedWithoutHarm) {
    // All anchors are one handle, so that the way is taken in steps as well.
    const Mesh mesh = capped_tube(16, 30, 8.0);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Binding binding = binding_of(mesh, anchors, Method::kFast, 1);
    binding.handles.assign(8, 0);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, 3.0, {5, -2, 1});
    const Positions found = solve(*bound(binding), rows_of(moved, anchors)).vertices;
    EXPECT_LT(largest_distance(found, moved), 1e-9 * mesh.diagonal());
}

TEST(FastDecoder, DoesNotDependOnUnitsOrPlace) {
    const Pose pose = two_ends("bend", capped_tube(16, 25, 8.0), Vector3::UnitX(), 1.0, {0, 2, -1});
    const Positions expected = solve(*bound_to(pose.mesh, pose.anchors), pose.targets).vertices;
    for (const double scale : {1e-6, 1e-3, 1e4, 1e6}) {
        Mesh mesh = pose.mesh;
        mesh.vertices *= scale;
        const Positions scaled = solve(*bound_to(mesh, pose.anchors), scale * pose.targets).vertices;
        EXPECT_LT(largest_distance(scaled / scale, expected), 1e-6 * pose.mesh.diagonal()) << scale;
    }
    for (const double far : {1.0, 2000.0}) {  // 2000: at 1e5 diagonals, whose coordinates are rounded to 1e-11 of one
        Mesh mesh = pose.mesh;
        const Eigen::RowVector3d shift = far * Eigen::RowVector3d(300, -200, 100);
        mesh.vertices.rowwise() += shift;
        const Positions shifted = solve(*bound_to(mesh, pose.anchors), pose.targets.rowwise() + shift).vertices;
        const double most = (far > 1.0 ? 1e-3 : 1e-6) * pose.mesh.diagonal();
        EXPECT_LT(largest_distance(shifted.rowwise() - shift, expected), most);
    }
}

/// With a coarse level, whose vertices are the same ones only if order and size turn with the mesh. Other numbers of
/// vertices along a curve in space make another order of elimination, whose rounding moves where a solve stops.
TEST(FastDecoder, DoesNotDependOnHowTheMeshIsTurned) {
    SolveOptions to_the_end;
    to_the_end.tolerance = 1e-9;
    Mesh symmetric = capped_tube(40, 80, 8.0);
    symmetric.vertices.col(0) *= 1.4;
    for (const Mesh& mesh : {symmetric, with_noise(symmetric, 0.05, 3)}) {
        const Pose pose = two_ends("bend", mesh, Vector3::UnitX(), 1.0, {0, 2, -1});
        const auto straight = bound_to(mesh, pose.anchors);
        const Positions stopped = solve(*straight, pose.targets).vertices;
        const Positions expected = solve(*straight, pose.targets, to_the_end).vertices;
        for (const double angle_rad : {0.3, 1.0, 2.5}) {
            const auto turn = [&](const Positions& positions) {
                return moved_by_similarity(positions, 1.0, Vector3(1, -2, 0.5), angle_rad, Vector3::Zero());
            };
            Mesh turned = mesh;
            turned.vertices = turn(mesh.vertices);
            const auto deformer = bound_to(turned, pose.anchors);
            const Positions found = solve(*deformer, turn(pose.targets)).vertices;
            EXPECT_LT(largest_distance(found, turn(stopped)), 3e-4 * mesh.diagonal()) << angle_rad;
            const Positions minimum = solve(*deformer, turn(pose.targets), to_the_end).vertices;
            EXPECT_LT(largest_distance(minimum, turn(expected)), 1e-8 * mesh.diagonal()) << angle_rad;
        }
    }
}

}  // namespace
}  // namespace meanvalue::tests
