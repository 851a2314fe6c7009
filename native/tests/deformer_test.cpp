#include "meanvalue/deform/deformer.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "meanvalue/common/errors.h"
#include "meanvalue/morph/morpher.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::unique_ptr<Deformer> bound_to(const Mesh& mesh, const std::vector<Index>& anchors,
                                   const std::optional<std::vector<char>>& roi = {}, int threads = 1) {
    Execution execution;
    Binding binding(mesh.vertices, mesh.faces, anchors, roi);
    binding.method = Method::kFull;
    binding.threads = threads;
    return std::make_unique<Deformer>(binding, execution);
}

Solution solve(Deformer& deformer, const Positions& targets) {
    Execution execution;
    return deformer.solve(targets, {}, SolveOptions(), execution);
}

void expect_energy_never_rises(const Solution& solution) {
    for (std::size_t k = 1; k < solution.energies.size(); ++k) {
        EXPECT_LE(solution.energies[k], solution.energies[k - 1]) << "iteration " << k;
    }
}

class EveryShape : public testing::TestWithParam<Mesh> {};

TEST_P(EveryShape, UnmovedAnchorsGiveTheRestShape) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    const Solution solution = solve(*bound_to(mesh, anchors), rows_of(mesh.vertices, anchors));
    EXPECT_LT(largest_distance(solution.vertices, mesh.vertices), 1e-6 * mesh.diagonal());
    EXPECT_TRUE(solution.converged);
}

TEST_P(EveryShape, AnchorsMovedByASimilarityTakeTheShapeAlong) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    for (const double angle_deg : {20.0, 120.0, 180.0}) {
        const Positions moved = moved_by_similarity(mesh.vertices, 1.7, {1, 2, 3}, angle_deg * kPi / 180, {5, -2, 1});
        const Solution solution = solve(*bound_to(mesh, anchors), rows_of(moved, anchors));
        EXPECT_LT(largest_distance(solution.vertices, moved), 1e-6 * mesh.diagonal()) << angle_deg;
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape,
                         testing::Values(sphere(3), grid(9, 8, 0.05), torus(24, 12), with_noise(sphere(3), 0.1, 1),
                                         capped_tube(16, 12, 6.0)));

struct Twist {
    Mesh mesh = capped_tube(16, 25, 8.0);
    std::vector<Index> anchors;
    Positions targets;

    /// Both caps held by four vertices each, the upper one turned about the axis.
    explicit Twist(double angle_rad) {
        for (const Index v : {0, 4, 8, 12}) {
            anchors.push_back(v);
            anchors.push_back(24 * 16 + v);
        }
        targets = rows_of(mesh.vertices, anchors);
        const Positions turned =
            moved_by_similarity(mesh.vertices, 1.0, Vector3::UnitZ(), angle_rad, Vector3::Zero());
        for (std::size_t k = 1; k < anchors.size(); k += 2)
            targets.row(k) = turned.row(anchors[k]);
    }
};

TEST(Deformer, TwistConvergesInTheOrderOfThePapersNineIterations) {
    const Twist twist(kPi / 2);
    const Solution solution = solve(*bound_to(twist.mesh, twist.anchors), twist.targets);
    EXPECT_TRUE(solution.converged) << solution.stop_reason;
    EXPECT_LE(solution.iterations, 20);
    EXPECT_GT(solution.energy, 0.0);
    EXPECT_LT(solution.gradient, 1e-3 * solution.initial_gradient);
    expect_energy_never_rises(solution);
}

TEST(Deformer, AnchorsAreMetExactly) {
    const Twist twist(1.0);
    const Solution solution = solve(*bound_to(twist.mesh, twist.anchors), twist.targets);
    for (std::size_t k = 0; k < twist.anchors.size(); ++k) {
        EXPECT_EQ(solution.vertices.row(twist.anchors[k]), twist.targets.row(k));
    }
}

TEST(Deformer, SolvingAgainGivesTheSameBits) {
    const Twist twist(1.0);
    const auto deformer = bound_to(twist.mesh, twist.anchors);
    const Solution first = solve(*deformer, twist.targets);
    solve(*deformer, rows_of(twist.mesh.vertices, twist.anchors));
    EXPECT_EQ(first.vertices, solve(*deformer, twist.targets).vertices);
}

TEST(Deformer, GivesTheSameBitsForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(80, 60), 0.05, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0);
    EXPECT_EQ(solve(*bound_to(mesh, anchors, {}, 1), targets).vertices,
              solve(*bound_to(mesh, anchors, {}, 4), targets).vertices);
}

TEST(Deformer, OutsideTheRegionOfInfluenceNothingMoves) {
    const Mesh mesh = grid(15, 15, 0.02);
    const std::vector<char> roi = inside_grid(15, 15, 4);
    const auto deformer = bound_to(mesh, {112}, roi);
    EXPECT_EQ(deformer->report().free_count, 48);
    EXPECT_LT(deformer->report().row_count, 100);
    Positions target = mesh.vertices.row(112);
    target(0, 2) += 2.0;
    const Solution solution = solve(*deformer, target);
    for (Index v = 0; v < 225; ++v) {
        if (roi[v]) continue;
        EXPECT_EQ(solution.vertices.row(v), mesh.vertices.row(v)) << v;
    }
    EXPECT_GT(solution.vertices(111, 2), mesh.vertices(111, 2) + 0.5);  // neighbours follow
    expect_energy_never_rises(solution);
}

TEST(Deformer, APulledAnchorMakesNoSpike) {
    // The anchors' own rows are in the energy: without them the anchor would leave its ring behind.
    const Mesh mesh = grid(21, 21, 0.0);
    std::vector<char> roi(441, 1);
    for (Index k = 0; k < 21; ++k)
        roi[k] = roi[420 + k] = roi[21 * k] = roi[21 * k + 20] = 0;
    Positions target = mesh.vertices.row(220);
    target(0, 2) += 4.0;
    const Solution solution = solve(*bound_to(mesh, {220}, roi), target);
    const double ring_height = (solution.vertices(219, 2) + solution.vertices(221, 2)) / 2;
    EXPECT_LT(4.0 - ring_height, 0.25);  // a cone over ten edges would drop by 0.4
}

TEST(Deformer, AStartIsUsedForTheFreeVertices) {
    const Twist twist(kPi / 2);
    const auto deformer = bound_to(twist.mesh, twist.anchors);
    const Solution cold = solve(*deformer, twist.targets);
    Execution execution;
    const Solution warm = deformer->solve(twist.targets, PositionsView(cold.vertices), SolveOptions(), execution);
    EXPECT_LT(warm.iterations, cold.iterations);
    EXPECT_LT(largest_distance(warm.vertices, cold.vertices), 1e-4 * twist.mesh.diagonal());
}

TEST(Deformer, TooFewAnchorsLeaveWhatTheyDoNotDetermineNearTheStart) {
    const Mesh mesh = with_noise(sphere(2), 0.05, 1);
    for (Index count = 0; count <= 2; ++count) {
        std::vector<Index> anchors = spread_vertices(mesh, 3);
        anchors.resize(count);
        const auto deformer = bound_to(mesh, anchors);
        EXPECT_EQ(deformer->report().components.at(0).undetermined, count == 0 ? 7 : count == 1 ? 4 : 1);
        Positions targets = rows_of(mesh.vertices, anchors);
        targets.array() += 0.5;
        const Solution solution = solve(*deformer, targets);
        EXPECT_TRUE(solution.vertices.allFinite());
        // All anchors move by one translation: the nearest answer moves along, or stays where nothing pulls.
        const double shift = count == 0 ? 0.0 : 0.5;
        EXPECT_LT(largest_distance(solution.vertices, (mesh.vertices.array() + shift).matrix()), 1e-6);
    }
}

TEST(Deformer, APartWithoutAnchorsStaysAtRestWhereverItStarts) {
    const Mesh mesh = joined(sphere(2), grid(5, 5, 0.1));
    const std::vector<Index> anchors = {0, 2, 4, 5};
    const auto deformer = bound_to(mesh, anchors);
    ASSERT_EQ(deformer->report().components.size(), 2u);
    EXPECT_EQ(deformer->report().components[1].undetermined, 7);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.2, {0, 1, 1}, 1.0, {1, 0, 0});
    const Solution solution = solve(*deformer, rows_of(moved, anchors));
    EXPECT_EQ(deformer->report().free_count, 62);
    EXPECT_EQ(solution.vertices.bottomRows(25), mesh.vertices.bottomRows(25));
    EXPECT_LT(largest_distance(solution.vertices.topRows(66), moved.topRows(66)), 1e-6);
    Execution execution;
    const Solution started =
        deformer->solve(rows_of(moved, anchors), PositionsView(moved), SolveOptions(), execution);
    EXPECT_EQ(started.vertices.bottomRows(25), mesh.vertices.bottomRows(25));
}

TEST(Deformer, CollapsedTargetsGiveFiniteNumbers) {
    const Mesh mesh = sphere(2);
    const std::vector<Index> anchors = spread_vertices(mesh, 5);
    const Solution solution = solve(*bound_to(mesh, anchors), Positions::Constant(5, 3, 0.25));
    EXPECT_TRUE(solution.vertices.allFinite());
    expect_energy_never_rises(solution);
}

TEST(Deformer, LooseVerticesAndLoneTrianglesDoNoHarm) {
    Mesh mesh = joined(sphere(2), triangle());
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.bottomRows(1) << 7, 7, 7;
    const std::vector<Index> anchors = {0, 2, 4};
    const Solution solution = solve(*bound_to(mesh, anchors), 2.0 * rows_of(mesh.vertices, anchors));
    EXPECT_TRUE(solution.vertices.allFinite());
    EXPECT_EQ(solution.vertices.bottomRows(4), mesh.vertices.bottomRows(4));
}

TEST(Deformer, NothingFreeIsSolvedAtOnce) {
    const Mesh mesh = triangle();
    const Solution solution = solve(*bound_to(mesh, {0, 1, 2}), 2.0 * mesh.vertices);
    EXPECT_EQ(solution.vertices, Positions(2.0 * mesh.vertices));
    EXPECT_TRUE(solution.converged);
}

TEST(Deformer, AnIterationLimitIsKeptAndReported) {
    const Twist twist(kPi / 2);
    Execution execution;
    const SolveOptions options{1e-6, 2};
    const Solution solution = bound_to(twist.mesh, twist.anchors)->solve(twist.targets, {}, options, execution);
    EXPECT_EQ(solution.iterations, 2);
    EXPECT_FALSE(solution.converged);
    EXPECT_EQ(solution.stop_reason, "iteration limit");
}

TEST(Deformer, ACancelledSolveLeavesTheDeformerUsable) {
    const Twist twist(kPi / 2);
    const auto deformer = bound_to(twist.mesh, twist.anchors);
    const Solution before = solve(*deformer, twist.targets);
    Execution cancelled;
    cancelled.cancel();
    EXPECT_THROW(deformer->solve(twist.targets, {}, SolveOptions(), cancelled), Cancelled);
    for (int k = 0; k < 5; ++k) {  // somewhere in the middle, at whatever point that is
        Execution execution;
        std::thread canceller([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(2 * k));
            execution.cancel();
        });
        try {
            deformer->solve(twist.targets, {}, SolveOptions(), execution);
        } catch (const Cancelled&) {
        }
        canceller.join();
    }
    EXPECT_EQ(solve(*deformer, twist.targets).vertices, before.vertices);
}

TEST(Deformer, ASolveDoesNotWaitForAnother) {
    const Mesh mesh = with_noise(torus(80, 60), 0.05, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0);
    const auto deformer = bound_to(mesh, anchors);
    Execution first;
    std::atomic<bool> first_ended{false};
    std::thread solving([&] {
        SolveOptions endless;
        endless.tolerance = 1e-300;
        endless.max_iterations = 1000000;
        try {
            while (true)
                deformer->solve(targets, {}, endless, first);
        } catch (const Cancelled&) {
        }
        first_ended = true;
    });
    while (std::string(first.stage()) != "solve")
        std::this_thread::yield();
    Execution second;
    EXPECT_NO_THROW(deformer->solve(rows_of(mesh.vertices, anchors), {}, SolveOptions(), second));
    EXPECT_FALSE(first_ended);
    first.cancel();
    solving.join();
}

TEST(DeformerRejects, AnchorsOutsideTheMeshOrNamedTwice) {
    const Mesh mesh = sphere(1);
    std::string text = message_of<InvalidInput>([&] { bound_to(mesh, {0, 99}); });
    EXPECT_TRUE(contains(text, "anchor 1 is vertex 99")) << text;
    text = message_of<InvalidInput>([&] { bound_to(mesh, {3, 0, 3}); });
    EXPECT_TRUE(contains(text, "anchors 0 and 2 are both vertex 3")) << text;
}

TEST(DeformerRejects, NumbersThatAreNotFiniteByIndex) {
    Mesh mesh = sphere(1);
    const auto deformer = bound_to(mesh, {0, 1, 2});
    Positions targets = rows_of(mesh.vertices, {0, 1, 2});
    targets(1, 2) = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { solve(*deformer, targets); }), "targets[1]"));
    mesh.vertices(7, 0) = std::nan("");
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { bound_to(mesh, {0}); }), "vertices[7]"));
}

TEST(DeformerRejects, SizesOutsideTheRangeOfDoubles) {
    for (const double scale : {1e-90, 1e90}) {
        Mesh mesh = sphere(1);
        mesh.vertices *= scale;
        EXPECT_TRUE(contains(message_of<InvalidInput>([&] { bound_to(mesh, {0}); }), "vertices span"));
    }
}

TEST(DeformerRejects, WrongSizesAndOptions) {
    const Mesh mesh = sphere(1);
    EXPECT_TRUE(
        contains(message_of<InvalidInput>([&] { bound_to(mesh, {0}, std::vector<char>(5, 1)); }), "roi has 5"));
    const auto deformer = bound_to(mesh, {0, 1, 2});
    Execution execution;
    const Positions targets = rows_of(mesh.vertices, {0, 1, 2});
    EXPECT_THROW(solve(*deformer, targets.topRows(2)), InvalidInput);
    EXPECT_THROW(deformer->solve(targets, PositionsView(targets), SolveOptions(), execution), InvalidInput);
    EXPECT_THROW(deformer->solve(targets, {}, SolveOptions{0.0, 10}, execution), InvalidInput);
    EXPECT_THROW(deformer->solve(targets, {}, SolveOptions{1e-6, -1}, execution), InvalidInput);
    EXPECT_TRUE(contains(message_of<InvalidInput>([] { method_from_name("magic"); }), "'full'"));
}

/// As libigl has meshes.
struct ColumnMajor {
    Eigen::MatrixXd vertices;
    Eigen::MatrixXi faces;
    explicit ColumnMajor(const Mesh& mesh) : vertices(mesh.vertices), faces(mesh.faces) {}
};

TEST(Inputs, BindingsOwnWhatTheyWereMadeFromInAnyLayoutAndMayBeCopied) {
    const Mesh mesh = torus(16, 8);
    const std::vector<Index> anchors = {0, 9, 40, 77};
    Positions targets = rows_of(mesh.vertices, anchors);
    targets(0, 2) += 0.3;
    const Solution expected = Deformer(Binding(mesh.vertices, mesh.faces, anchors)).solve(targets);
    std::vector<Binding> bindings;
    {
        const ColumnMajor given(mesh);
        bindings.emplace_back(given.vertices, given.faces, anchors);
        for (int copy = 0; copy < 5; ++copy)
            bindings.push_back(bindings.front());
        EXPECT_EQ(bindings.back().vertices, bindings.front().vertices);  // copied once
    }
    const Binding last = bindings.back();
    bindings.clear();
    const Deformer deformer(last);
    EXPECT_EQ(&deformer.bound().rest(), last.vertices.get());  // and not at bind
    EXPECT_EQ(deformer.solve(Eigen::MatrixXd(targets)).vertices, expected.vertices);
}

TEST(Inputs, MorphBindingsOwnWhatTheyWereMadeFromInAnyLayoutAndMayBeCopied) {
    const Mesh mesh = torus(16, 8);
    const Positions other = moved_by_similarity(mesh.vertices, 1.2, {0, 0, 1}, 0.7, {0, 0, 0});
    const std::vector<Positions> rows = {mesh.vertices, other};
    const Solution expected = Morpher(MorphBinding(rows, mesh.faces)).solve({0.5, 0.5});
    std::vector<MorphBinding> bindings;
    {
        std::vector<Eigen::MatrixXd> shapes = {rows[0], rows[1]};
        bindings.emplace_back(shapes, ColumnMajor(mesh).faces);
        bindings.push_back(bindings.front());
        bindings.front().shapes.push_back(share(Eigen::MatrixXd(other), "other"));
    }
    const Morpher morpher(bindings.back());
    bindings.clear();
    EXPECT_EQ(morpher.solve({0.5, 0.5}).vertices, expected.vertices);
}

TEST(Inputs, OfOtherThanThreeColumnsAreRefusedByName) {
    const Mesh mesh = torus(16, 8);
    const ColumnMajor given(mesh);
    const auto refusal = [](const auto& action) { return message_of<InvalidInput>(action); };
    EXPECT_TRUE(contains(refusal([&] { Binding(Eigen::MatrixXd(given.vertices.leftCols(2)), given.faces, {0}); }),
                         "vertices has 2 columns; give 3"));
    EXPECT_TRUE(contains(refusal([&] { Binding(given.vertices, Eigen::MatrixXi::Zero(5, 4).eval(), {0}); }),
                         "faces has 4 columns; give 3"));
    const Deformer deformer(Binding(given.vertices, given.faces, {0}));
    EXPECT_TRUE(contains(refusal([&] { deformer.solve(Eigen::MatrixXd::Zero(1, 2).eval()); }),
                         "targets has 2 columns; give 3"));
}

TEST(Inputs, ABindingOfAnEqualMeshIsBoundAgainAsThatOfTheEarlierOne) {
    const Mesh mesh = torus(16, 8);
    const Deformer first(binding_of(mesh, {0, 9, 40}));
    Execution execution;
    const Deformer again(binding_of(mesh, {0, 9, 77}), execution, &first);
    EXPECT_EQ(&again.bound().rest(), &first.bound().rest());
}

}  // namespace
}  // namespace meanvalue::tests
