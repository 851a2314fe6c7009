// What a drag shows while its next answer is solved.
#include <cmath>
#include <limits>
#include <optional>

#include "meanvalue/deform/deformer.h"
#include "tests/fast_poses.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// A tube whose upper end is bent a little more in each frame.
struct Bend {
    Mesh mesh = capped_tube(40, 60, 8.0);
    std::vector<Index> anchors = bend("", mesh, 0.1).anchors;

    Positions at(double angle_rad) const { return bend("", mesh, angle_rad).targets; }
    double size() const { return mesh.diagonal(); }
    std::unique_ptr<Deformer> bound(Method method = Method::kFast, int threads = 1) const {
        return tests::bound(binding_of(mesh, anchors, method, threads));
    }
    std::unique_ptr<Deformer> soft() const {
        Binding binding = binding_of(mesh, anchors, Method::kFast, 1);
        binding.strengths.assign(anchors.size(), 10.0);
        return tests::bound(binding);
    }
};

double rms(const Positions& a, const Positions& b) {
    return (a - b).norm() / std::sqrt(static_cast<double>(a.rows()));
}

TEST(Draft, AnchorsAreMetAndTheErrorFallsWithTheSquareOfTheMove) {
    const Bend bent;
    const auto deformer = bent.bound();
    const auto error = [&](double step) {
        Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
        for (int frame = 1; frame <= 2; ++frame)
            solve_next(drag, bent.at(0.3 + frame * step));
        const Positions targets = bent.at(0.3 + 3 * step);
        const std::optional<Positions> draft = drag.draft(targets);
        EXPECT_TRUE(draft);
        EXPECT_EQ(rows_of(*draft, bent.anchors), targets);
        return rms(*draft, solve_next(drag, targets).vertices);
    };
    EXPECT_LT(error(0.1), 1.5e-3 * bent.size());
    EXPECT_GT(error(0.2) / error(0.1), 3.0);
}

TEST(Draft, TheFirstAnswersToAMoveOfAnotherKindAreTheInitialHessians) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    solve_next(drag, bent.at(0.05));
    const Positions last = solve_next(drag, bent.at(0.1)).vertices;
    Positions targets = bent.at(0.1);
    for (std::size_t k = 0; k < bent.anchors.size(); ++k) {
        if (bent.mesh.vertices(bent.anchors[k], 2) > 4.0) targets.row(k) += Vector3(0.5, 0.2, -0.1).transpose();
    }
    SolveOptions no_steps;
    no_steps.max_iterations = 0;
    const Positions answered = solve_from(*deformer, targets, last, no_steps).vertices;
    const std::optional<Positions> draft = drag.draft(targets);
    ASSERT_TRUE(draft);
    EXPECT_LT(largest_distance(*draft, answered), 1e-2 * largest_distance(answered, last));
}

TEST(Draft, DraftsBeginWithTheFirstSolve) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    EXPECT_FALSE(drag.draft(bent.at(0.1)));
    SolveOptions no_steps;
    no_steps.max_iterations = 0;
    solve_next(drag, bent.at(0.01), no_steps);
    const std::optional<Positions> draft = drag.draft(bent.at(0.3));
    ASSERT_TRUE(draft);
    const Positions answer = solve_from(*deformer, bent.at(0.3), bent.mesh.vertices).vertices;
    EXPECT_LT(rms(*draft, answer), 0.5 * rms(bent.mesh.vertices, answer));
}

TEST(Draft, TheFirstSolveOfADragBeginsWithTheCoarseLevelsAnswer) {
    int of_drags = 0;
    int of_solves = 0;
    for (const Pose& pose : poses()) {
        const auto deformer = bound_to(pose.mesh, pose.anchors);
        if (deformer->report().level_sizes.size() < 2) continue;
        Deformer::Drag drag(*deformer, PositionsView(pose.mesh.vertices));
        const Positions rest = rows_of(pose.mesh.vertices, pose.anchors);
        const Positions targets = rest + 0.2 * (pose.targets - rest);
        const Solution alone = solve_from(*deformer, targets, pose.mesh.vertices);
        const Solution first = solve_next(drag, targets);
        EXPECT_LT(first.energy, 1.001 * alone.energy) << pose.name;
        of_drags += first.iterations;
        of_solves += alone.iterations;
    }
    EXPECT_GT(of_drags, 0);
    EXPECT_LT(of_drags, 0.75 * of_solves);
}

TEST(Draft, SolvesDoNotDependOnDrafts) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag asked(*deformer, PositionsView(bent.mesh.vertices));
    Deformer::Drag left_alone(*deformer, PositionsView(bent.mesh.vertices));
    for (int frame = 1; frame <= 4; ++frame) {
        asked.draft(bent.at(0.1 * frame + 0.03));
        EXPECT_EQ(solve_next(asked, bent.at(0.1 * frame)).vertices,
                  solve_next(left_alone, bent.at(0.1 * frame)).vertices);
    }
    EXPECT_EQ(asked.draft(bent.at(0.5), 1).value(), left_alone.draft(bent.at(0.5), 3).value());
}

TEST(Draft, ThereIsNoneWhereTooLittleIsKnown) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    solve_next(drag, bent.at(0.1));
    Positions torn = bent.at(0.2);
    for (std::size_t k = 0; k < bent.anchors.size(); ++k) {
        const double x = bent.mesh.vertices(bent.anchors[k], 0);
        if (bent.mesh.vertices(bent.anchors[k], 2) > 4.0) torn(static_cast<Index>(k), 2) += x * x;
    }
    EXPECT_FALSE(drag.draft(torn)) << "no affine move of the handle";
    EXPECT_TRUE(drag.draft(bent.at(0.2)));
    SolveOptions settled;
    settled.settle = true;
    solve_next(drag, bent.at(0.2), settled);
    EXPECT_FALSE(drag.draft(bent.at(0.3))) << "settled: the next solve begins anew";
    Bend small;
    small.mesh = capped_tube(12, 25, 8.0);
    small.anchors = bend("", small.mesh, 0.1).anchors;
    const auto full = small.bound(Method::kFull);
    Deformer::Drag by_full(*full, PositionsView(small.mesh.vertices));
    solve_next(by_full, small.at(0.1));
    EXPECT_FALSE(by_full.draft(small.at(0.2)));
}

TEST(Draft, HandlesMovedInTurnHaveDraftsHoweverManyTheyAre) {
    const Mesh mesh = sphere(5);
    const std::vector<Index> anchors = spread_vertices(mesh, 10);
    const auto deformer = bound_to(mesh, anchors);
    Deformer::Drag drag(*deformer, PositionsView(mesh.vertices));
    Positions targets = rows_of(mesh.vertices, anchors);
    for (Index handle = 0; handle < 10; ++handle) {
        targets(handle, 0) += 0.01;
        solve_next(drag, targets);
        Positions next = targets;
        next(handle, 2) += 0.1;
        EXPECT_TRUE(drag.draft(next)) << handle;
    }
}

TEST(Draft, MovesOfManyHandlesAtOnceAreLeftToTheSolver) {
    const Mesh mesh = sphere(5);
    const std::vector<Index> anchors = spread_vertices(mesh, 20);
    const auto deformer = bound_to(mesh, anchors);
    for (const Index count : {6, 12}) {
        Deformer::Drag drag(*deformer, PositionsView(mesh.vertices));
        Positions targets = rows_of(mesh.vertices, anchors);
        targets.topRows(count).col(0).array() += 0.01;
        solve_next(drag, targets);
        targets.topRows(count).col(2).array() += 0.05;
        EXPECT_EQ(drag.draft(targets).has_value(), count == 6);
    }
}

TEST(Draft, SoftHandlesHaveSomeToo) {
    const Bend bent;
    const auto deformer = bent.soft();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    solve_next(drag, bent.at(0.1));
    const Positions last = solve_next(drag, bent.at(0.2)).vertices;
    const std::optional<Positions> draft = drag.draft(bent.at(0.3));
    ASSERT_TRUE(draft);
    const Positions answer = solve_next(drag, bent.at(0.3)).vertices;
    EXPECT_LT(rms(*draft, answer), 0.2 * rms(last, answer));
    SolveOptions some;
    SolveOptions settled;
    settled.settle = true;
    solve_next(drag, bent.at(0.3), settled);
    const Positions before = solve_next(drag, bent.at(0.3)).vertices;
    const std::optional<Positions> after_settling = drag.draft(bent.at(0.4));
    ASSERT_TRUE(after_settling);
    EXPECT_GT(rms(*after_settling, before), 0.05 * bent.size() * 0.1);
    some.weights.assign(bent.anchors.size(), 0.5);
    solve_next(drag, bent.at(0.3), some);
    EXPECT_FALSE(drag.draft(bent.at(0.4))) << "they do not count fully";
}

TEST(Draft, TheSecondSolveOfSoftHandlesBeginsWithTheirMove) {
    const Bend bent;
    const auto deformer = bent.soft();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    const Positions first = solve_next(drag, bent.at(0.1)).vertices;
    SolveOptions no_steps;
    no_steps.max_iterations = 0;
    const Positions start = solve_next(drag, bent.at(0.2), no_steps).vertices;
    const Positions answer = solve_next(drag, bent.at(0.2)).vertices;
    EXPECT_LT(rms(start, answer), 0.6 * rms(first, answer));
}

TEST(Draft, TargetsThatNoSolveTakesAreRefused) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    solve_next(drag, bent.at(0.1));
    Positions targets = bent.at(0.2);
    targets(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(message_of<InvalidInput>([&] { drag.draft(targets); }), "");
    EXPECT_NE(message_of<InvalidInput>([&] { drag.draft(bent.at(0.2).topRows(3)); }), "");
}

TEST(Draft, ItIsCancelledAndCanBeHadThen) {
    const Bend bent;
    const auto deformer = bent.bound();
    Deformer::Drag drag(*deformer, PositionsView(bent.mesh.vertices));
    solve_next(drag, bent.at(0.1));
    solve_next(drag, bent.at(0.2));
    Execution cancelled;
    cancelled.cancel();
    EXPECT_THROW(drag.draft(bent.at(0.3), 1, cancelled), Cancelled);
    EXPECT_TRUE(drag.draft(bent.at(0.3)));
}

}  // namespace
}  // namespace meanvalue::tests
