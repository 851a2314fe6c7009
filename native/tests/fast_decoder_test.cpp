#include "meanvalue/decode/fast/fast_decoder.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>

#include "meanvalue/common/errors.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

class EveryFastShape : public testing::TestWithParam<Mesh> {};

TEST_P(EveryFastShape, UnmovedAnchorsGiveTheRestShape) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 16);
    for (const double rigidity : {0.0, kDefaultRigidity}) {
        const Solution solution = solve(*bound_to(mesh, anchors, rigidity), rows_of(mesh.vertices, anchors));
        EXPECT_LT(largest_distance(solution.vertices, mesh.vertices), 1e-9 * mesh.diagonal()) << rigidity;
        EXPECT_TRUE(solution.converged);
    }
}

TEST_P(EveryFastShape, AnchorsMovedRigidlyTakeTheShapeAlong) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 16);
    for (const double rigidity : {0.0, kDefaultRigidity}) {
        const auto deformer = bound_to(mesh, anchors, rigidity);
        for (const double angle_deg : {20.0, 120.0, 180.0}) {
            const Positions moved =
                moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, angle_deg * kPi / 180, {5, -2, 1});
            const Solution solution = solve(*deformer, rows_of(moved, anchors));
            EXPECT_LT(largest_distance(solution.vertices, moved), 1e-9 * mesh.diagonal())
                << angle_deg << " degrees, rigidity " << rigidity;
        }
    }
}

double off_similarity(const Mesh& mesh, Index anchor_count, double scale) {
    const std::vector<Index> anchors = spread_vertices(mesh, anchor_count);
    const Positions moved = moved_by_similarity(mesh.vertices, scale, {3, 1, 2}, 2.0, {1, 2, 3});
    const Solution solution = solve(*bound_to(mesh, anchors, 0.0), rows_of(moved, anchors));
    return largest_distance(solution.vertices, moved) / (std::max(1.0, scale) * mesh.diagonal());
}

TEST_P(EveryFastShape, WithoutRigidityASimilarityIsMetExactly) {
    // The stiff stages would lead away from it.
    for (const double scale : {0.3, 0.9, 1.7})
        EXPECT_LT(off_similarity(GetParam(), 8, scale), 1e-9) << scale;
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryFastShape,
                         testing::Values(sphere(3), with_noise(sphere(3), 0.1, 1), grid(20, 18, 0.02), torus(30, 16),
                                         capped_tube(16, 12, 6.0), bar(4, 16),
                                         joined(grid(9, 8, 0.05), grid(8, 9, 0.02)), sphere(5), torus(80, 60)));

TEST(FastDecoder, AHandleThatMovesWithEverythingIsFollowedWithoutHarm) {
    // All anchors are one handle, so that the way is taken in steps as well.
    const Mesh mesh = capped_tube(16, 30, 8.0);
    Execution execution;
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const std::vector<Index> handles(8, 0);
    Binding binding = binding_of(mesh, anchors, Method::kFast, 1);
    binding.handles = handles;
    Deformer deformer(binding, execution);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, 3.0, {5, -2, 1});
    EXPECT_LT(largest_distance(solve(deformer, rows_of(moved, anchors)).vertices, moved), 1e-9 * mesh.diagonal());
}

TEST(FastDecoder, GivesTheSameBitsForAnyNumberOfThreadsWithAndWithoutAStart) {
    for (const Pose& pose : {poses()[0], poses()[7]}) {
        const auto one = bound_to(pose.mesh, pose.anchors, {}, 1);
        const auto four = bound_to(pose.mesh, pose.anchors, {}, 4);
        const Solution first = solve(*one, pose.targets);
        EXPECT_EQ(first.vertices, solve(*four, pose.targets).vertices) << pose.name;
        EXPECT_EQ(first.vertices, solve(*one, pose.targets).vertices) << pose.name;
        EXPECT_EQ(first.energies, solve(*four, pose.targets).energies) << pose.name;
        const Positions further = 1.05 * pose.targets;
        EXPECT_EQ(solve_from(*one, further, first.vertices).vertices,
                  solve_from(*four, further, first.vertices).vertices)
            << pose.name;
    }
}

TEST(FastDecoder, LargeMeshesHaveACoarseLevelAndSmallOnesNone) {
    EXPECT_EQ(bound_to(sphere(3), {0, 1, 2, 3})->report().level_sizes, std::vector<Index>{254});
    const Mesh mesh = sphere(5);
    const std::vector<Index> sizes = bound_to(mesh, {0, 1, 2, 3})->report().level_sizes;
    ASSERT_EQ(sizes.size(), 2u);
    EXPECT_EQ(sizes[0], mesh.vertex_count() - 4);
    EXPECT_LT(sizes[1], sizes[0] / 2);
}

TEST(FastDecoder, OutsideTheRegionOfInfluenceNothingMoves) {
    for (const Index width : {41, 91}) {  // the larger one has a coarse level
        const Mesh mesh = grid(width, width, 0.01);
        const std::vector<char> roi = inside_grid(width, width, 10);
        const Index middle = width / 2 * width + width / 2;
        const auto deformer = bound_to(mesh, {middle}, {}, 1, roi);
        EXPECT_EQ(deformer->report().level_sizes.size(), width == 91 ? 2u : 1u);
        Positions target = mesh.vertices.row(middle);
        target(0, 2) += 5.0;
        const Solution solution = solve(*deformer, target);
        EXPECT_EQ(solution.vertices.row(middle), target.row(0));
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            if (roi[v]) continue;
            ASSERT_EQ(solution.vertices.row(v), mesh.vertices.row(v)) << v;
        }
        EXPECT_GT(solution.vertices(middle + 1, 2), mesh.vertices(middle + 1, 2) + 2.0);
        expect_energy_never_rises(solution);
    }
}

TEST(FastDecoder, APartWithoutAnchorsStaysWhereItIs) {
    const Mesh mesh = joined(sphere(3), torus(12, 8));
    const std::vector<Index> anchors = {0, 2, 4, 5};
    const auto deformer = bound_to(mesh, anchors);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {0, 1, 1}, 1.0, {1, 0, 0});
    const Solution solution = solve(*deformer, rows_of(moved, anchors));
    EXPECT_EQ(solution.vertices.bottomRows(96), mesh.vertices.bottomRows(96));
    EXPECT_LT(largest_distance(solution.vertices.topRows(258), moved.topRows(258)), 1e-8);
    const Solution started = solve_from(*deformer, rows_of(moved, anchors), moved);
    EXPECT_EQ(started.vertices.bottomRows(96), mesh.vertices.bottomRows(96)) << "wherever a solve starts";
}

TEST(FastDecoder, FewAnchorsMoveTheShapeAlong) {
    for (const Mesh& mesh : {with_noise(sphere(3), 0.05, 1), with_noise(sphere(5), 0.05, 1)}) {
        const std::vector<Index> spread = spread_vertices(mesh, 3);
        for (std::size_t count = 0; count <= 3; ++count) {
            const std::vector<Index> anchors(spread.begin(), spread.begin() + static_cast<std::ptrdiff_t>(count));
            const Vector3 shift(count == 0 ? 0.0 : 0.5, 0.0, 0.0);
            const Positions moved = mesh.vertices.rowwise() + shift.transpose();
            for (const double rigidity : {0.0, kDefaultRigidity}) {
                const Solution solution = solve(*bound_to(mesh, anchors, rigidity), rows_of(moved, anchors));
                ASSERT_TRUE(solution.vertices.allFinite());
                EXPECT_LT(largest_distance(solution.vertices, moved), 1e-6 * mesh.diagonal())
                    << count << " anchors, rigidity " << rigidity;
            }
        }
    }
}

TEST(FastDecoder, FewCollinearOrCoincidentAnchorsGiveFiniteAnswers) {
    for (const double rigidity : {0.0, kDefaultRigidity}) {
        Mesh mesh = with_noise(sphere(3), 0.05, 1);
        const std::vector<Index> spread = spread_vertices(mesh, 5);
        for (std::ptrdiff_t count = 1; count <= 5; ++count) {
            const std::vector<Index> anchors(spread.begin(), spread.begin() + count);
            const auto deformer = bound_to(mesh, anchors, rigidity);
            Positions targets = rows_of(mesh.vertices, anchors);
            for (const double scale : {-1.0, 0.0, 1e-12, 3.0}) {
                const Solution solution = solve(*deformer, scale * targets);
                EXPECT_TRUE(solution.vertices.allFinite()) << count << " anchors, scale " << scale;
                EXPECT_LT(solution.vertices.cwiseAbs().maxCoeff(), 20.0) << count << " anchors, scale " << scale;
                expect_energy_never_rises(solution);
            }
        }
        // On one line at rest, and turned about it.
        const std::vector<Index> anchors(spread.begin(), spread.begin() + 4);
        for (int k = 0; k < 4; ++k)
            mesh.vertices.row(anchors[k]) << 0.3 * k - 0.5, 0.0, 1.2;
        const auto deformer = bound_to(mesh, anchors, rigidity);
        for (const double angle_rad : {0.0, 1.0, kPi}) {
            const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {0, 0, 1}, angle_rad, {0, 1, 0});
            const Solution solution = solve(*deformer, rows_of(moved, anchors));
            EXPECT_TRUE(solution.vertices.allFinite());
            EXPECT_LT(solution.energy, 1e-6) << angle_rad;
        }
    }
}

TEST(FastDecoder, CoincidingVerticesAndLooseOnesDoNoHarm) {
    Mesh mesh = joined(sphere(3), triangle());
    mesh.vertices.row(7) = mesh.vertices.row(100);  // not neighbours
    mesh.vertices.row(mesh.faces(20, 0)) = mesh.vertices.row(mesh.faces(20, 1));
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.bottomRows(1) << 7, 7, 7;
    const std::vector<Index> anchors = spread_vertices(sphere(3), 5);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(2) *= 1.5;
    for (const double rigidity : {0.0, kDefaultRigidity}) {
        const Solution solution = solve(*bound_to(mesh, anchors, rigidity), targets);
        EXPECT_TRUE(solution.vertices.allFinite());
        EXPECT_LT(solution.vertices.topRows(258).cwiseAbs().maxCoeff(), 5.0);
        EXPECT_EQ(solution.vertices.bottomRows(4), mesh.vertices.bottomRows(4));
    }
}

TEST(FastDecoder, DoesNotDependOnUnitsOrPlace) {
    const Pose pose = two_ends("bend", capped_tube(16, 25, 8.0), Vector3::UnitX(), 1.0, {0, 2, -1});
    const Positions expected = solve(*bound_to(pose.mesh, pose.anchors), pose.targets).vertices;
    for (const double scale : {1e-3, 1e4}) {
        Mesh mesh = pose.mesh;
        mesh.vertices *= scale;
        const Positions scaled = solve(*bound_to(mesh, pose.anchors), scale * pose.targets).vertices;
        EXPECT_LT(largest_distance(scaled / scale, expected), 1e-6 * pose.mesh.diagonal()) << scale;
    }
    Mesh mesh = pose.mesh;
    const Eigen::RowVector3d shift(300, -200, 100);
    mesh.vertices.rowwise() += shift;
    const Positions shifted = solve(*bound_to(mesh, pose.anchors), pose.targets.rowwise() + shift).vertices;
    EXPECT_LT(largest_distance(shifted.rowwise() - shift, expected), 1e-6 * pose.mesh.diagonal());
}

/// With a coarse level, whose vertices are the same ones only if order and size turn with the mesh.
TEST(FastDecoder, DoesNotDependOnHowTheMeshIsTurned) {
    Mesh symmetric = capped_tube(40, 80, 8.0);
    symmetric.vertices.col(0) *= 1.4;
    for (const Mesh& mesh : {symmetric, with_noise(symmetric, 0.05, 3)}) {
        const Pose pose = two_ends("bend", mesh, Vector3::UnitX(), 1.0, {0, 2, -1});
        const Positions expected = solve(*bound_to(mesh, pose.anchors), pose.targets).vertices;
        for (const double angle_rad : {0.3, 1.0, 2.5}) {
            const auto turn = [&](const Positions& positions) {
                return moved_by_similarity(positions, 1.0, Vector3(1, -2, 0.5), angle_rad, Vector3::Zero());
            };
            Mesh turned = mesh;
            turned.vertices = turn(mesh.vertices);
            const Positions found = solve(*bound_to(turned, pose.anchors), turn(pose.targets)).vertices;
            EXPECT_LT(largest_distance(found, turn(expected)), 1e-4 * mesh.diagonal()) << angle_rad;
        }
    }
}

TEST(FastDecoder, AnIterationLimitIsKeptAndReported) {
    const Pose pose = poses()[7];
    for (const int limit : {0, 2}) {
        const Solution solution = solve(*bound_to(pose.mesh, pose.anchors), pose.targets, {{}, limit});
        EXPECT_EQ(solution.iterations, limit);
        EXPECT_FALSE(solution.converged);
        EXPECT_EQ(solution.stop_reason, "iteration limit");
        EXPECT_TRUE(solution.vertices.allFinite());
        EXPECT_EQ(rows_of(solution.vertices, pose.anchors), pose.targets);
    }
}

/// Cancels `action` at several moments between its start and its end; the last one may come too late.
template <typename Action>
void cancel_here_and_there(const Action& action) {
    const auto begin = std::chrono::steady_clock::now();
    Execution whole;
    action(whole);
    const auto length = std::chrono::steady_clock::now() - begin;
    int cancelled = 0;
    for (const double share : {0.0, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95}) {
        Execution execution;
        std::thread canceller([&] {
            std::this_thread::sleep_for(share * length);
            execution.cancel();
        });
        try {
            action(execution);
        } catch (const Cancelled&) {
            ++cancelled;
        }
        canceller.join();
    }
    EXPECT_GT(cancelled, 0);
}

TEST(FastDecoder, ACancelledSolveLeavesTheDeformerUsable) {
    const Pose pose = poses()[7];
    const auto deformer = bound_to(pose.mesh, pose.anchors, {}, 2);
    const Solution before = solve(*deformer, pose.targets);
    cancel_here_and_there([&](Execution& execution) { deformer->solve(pose.targets, {}, {}, execution); });
    EXPECT_EQ(solve(*deformer, pose.targets).vertices, before.vertices);
}

TEST(FastDecoder, ACancelledBindLeavesTheNextOneWhole) {
    const Pose pose = poses()[7];
    const Solution before = solve(*bound_to(pose.mesh, pose.anchors), pose.targets);
    cancel_here_and_there([&](Execution& execution) {
        const Deformer deformer(binding_of(pose.mesh, pose.anchors, Method::kFast, 1), execution);
    });
    EXPECT_EQ(solve(*bound_to(pose.mesh, pose.anchors), pose.targets).vertices, before.vertices);
}

std::string refusal(const std::vector<Index>& handles, std::optional<double> rigidity,
                    Method method = Method::kFast) {
    const Mesh mesh = sphere(2);
    return message_of<InvalidInput>([&] {
        Execution execution;
        Binding binding = binding_of(mesh, {0, 1, 2, 3}, method, 1, rigidity);
        binding.handles = handles;
        const Deformer deformer(binding, execution);
    });
}

TEST(FastDecoderRejects, HandlesAndRigidityThatMakeNoSense) {
    EXPECT_EQ(refusal({0, 1}, {}), "handles has 2 numbers, but there are 4 anchors; give one number for each");
    EXPECT_EQ(refusal({0, 1, -1, 2}, {}), "handles[2] is -1; give numbers from 0");
    EXPECT_EQ(refusal({}, -1.0), "rigidity is -1; give 0 or a positive number");
    EXPECT_TRUE(contains(refusal({}, std::numeric_limits<double>::quiet_NaN()), "rigidity is nan"));
    EXPECT_TRUE(contains(refusal({}, std::numeric_limits<double>::infinity()), "rigidity is inf"));
    for (const Method method : {Method::kPaper, Method::kFull}) {
        EXPECT_EQ(refusal({}, 1.0, method),
                  "rigidity is 1; only method 'fast' has one: give 0 or None to the others");
        EXPECT_TRUE(contains(refusal({}, -1.0, method), "give 0 or a positive number"));
        EXPECT_TRUE(contains(refusal({0}, 0.0, method), "handles has 1"));
    }
}

TEST(FastDecoder, IsWhatABindingIsMadeWithUnlessToldOtherwise) {
    // No tolerance, rigidity or method given: as in C++, so in Python, where the host tests look.
    const Mesh mesh = sphere(3);
    const std::vector<Index> anchors = spread_vertices(mesh, 5);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(0) *= 1.5;
    const Positions expected = solve(*bound_to(mesh, anchors, kDefaultRigidity), targets).vertices;
    EXPECT_EQ(solve(*bound_to(mesh, anchors), targets).vertices, expected);
    EXPECT_EQ(solve(*bound_to(mesh, anchors), targets, {1e-4, 100}).vertices, expected);
    EXPECT_NE(solve(*bound_to(mesh, anchors, 0.0), targets).vertices, expected);
    EXPECT_EQ(method_from_name("fast"), Method::kFast);
    EXPECT_TRUE(contains(message_of<InvalidInput>([] { method_from_name("quick"); }), "'fast', 'paper' and 'full'"));
}

}  // namespace
}  // namespace meanvalue::tests
