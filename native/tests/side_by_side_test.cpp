// One bound mesh solved by several threads at once, and drags on it that are cancelled.
#include <atomic>
#include <thread>

#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/deform/deformer.h"
#include "tests/fast_poses.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// A tube whose ends are anchors, with a coarse level; the upper end is bent by `step` more in each frame.
struct Drag {
    Mesh mesh;
    std::vector<Index> anchors;
    std::vector<Positions> frames;

    explicit Drag(double step, int count = 6, const Mesh& of = capped_tube(40, 60, 8.0)) : mesh(of) {
        for (int frame = 0; frame < count; ++frame) {
            Pose pose = two_ends("bend", mesh, Vector3::UnitX(), step * (frame + 1), {0, step * frame, 0});
            anchors = pose.anchors;
            frames.push_back(pose.targets);
        }
    }

    std::unique_ptr<Deformer> bound(Method method = Method::kFast, int threads = 1) const {
        return tests::bound(binding_of(mesh, anchors, method, threads));
    }

    /// The shape after every frame, each from the one before.
    std::vector<Positions> run(Deformer& deformer) const {
        Deformer::Drag drag(deformer, PositionsView(mesh.vertices));
        std::vector<Positions> shapes;
        shapes.reserve(frames.size());
        for (const Positions& targets : frames)
            shapes.push_back(solve_next(drag, targets).vertices);
        return shapes;
    }
};

TEST(SideBySide, ColdSolvesHaveTheBitsOfOneAfterTheOther) {
    for (const Method method : {Method::kFast, Method::kPaper, Method::kFull}) {
        const Drag poses(0.4, 3, method == Method::kFast ? capped_tube(40, 60, 8.0) : capped_tube(12, 25, 8.0));
        const auto deformer = poses.bound(method);
        std::vector<Positions> expected;
        expected.reserve(poses.frames.size());
        for (const Positions& targets : poses.frames)
            expected.push_back(solve(*deformer, targets).vertices);
        std::vector<std::vector<Positions>> found(4, std::vector<Positions>(poses.frames.size()));
        std::vector<std::thread> threads;
        threads.reserve(found.size());
        for (std::size_t number = 0; number < found.size(); ++number) {
            threads.emplace_back([&, number] {
                for (std::size_t k = 0; k < poses.frames.size(); ++k) {
                    const std::size_t frame = (k + number) % poses.frames.size();
                    found[number][frame] = solve(*deformer, poses.frames[frame]).vertices;
                }
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        for (const std::vector<Positions>& of_thread : found)
            EXPECT_EQ(of_thread, expected) << static_cast<int>(method);
    }
}

TEST(SideBySide, DragsHaveTheBitsThatEachHasAlone) {
    const Drag one(0.1), other(-0.15);
    const std::vector<Positions> expected_one = one.run(*one.bound());
    const std::vector<Positions> expected_other = other.run(*one.bound());
    const auto deformer = one.bound(Method::kFast, 2);
    for (int round = 0; round < 3; ++round) {
        std::vector<Positions> found_one, found_other;
        std::thread thread([&] { found_one = one.run(*deformer); });
        found_other = other.run(*deformer);
        thread.join();
        EXPECT_EQ(found_one, expected_one);
        EXPECT_EQ(found_other, expected_other);
    }
}

TEST(SideBySide, DragsInTurnDoNotDisturbEachOther) {
    const Drag one(0.1), other(-0.15);
    const std::vector<Positions> expected_one = one.run(*one.bound());
    const std::vector<Positions> expected_other = other.run(*one.bound());
    const auto deformer = one.bound();
    Deformer::Drag drag_one(*deformer, PositionsView(one.mesh.vertices));
    Deformer::Drag drag_other(*deformer, PositionsView(one.mesh.vertices));
    for (std::size_t frame = 0; frame < one.frames.size(); ++frame) {
        EXPECT_EQ(solve_next(drag_one, one.frames[frame]).vertices, expected_one[frame]) << frame;
        EXPECT_EQ(solve_next(drag_other, other.frames[frame]).vertices, expected_other[frame]) << frame;
        solve(*deformer, other.frames[frame]);  // nor does a solve from rest
    }
}

TEST(SideBySide, DraftsOfADragThatGoesOnDoNotDisturbIt) {
    const Drag frames(0.1);
    const auto deformer = frames.bound(Method::kFast, 2);
    const std::vector<Positions> expected = frames.run(*deformer);
    Deformer::Drag drag(*deformer, PositionsView(frames.mesh.vertices));
    std::vector<Positions> found;
    std::atomic<bool> is_done{false};
    std::thread solver([&] {
        for (const Positions& targets : frames.frames)
            found.push_back(solve_next(drag, targets).vertices);
        is_done = true;
    });
    int drafts = 0;
    while (!is_done)
        drafts += drag.draft(frames.frames.back()).has_value() ? 1 : 0;
    solver.join();
    EXPECT_GT(drafts, 0);
    EXPECT_EQ(found, expected);
}

TEST(SideBySide, ADragGoesOnWhereAFrameWasCancelled) {
    const Drag frames(0.1);
    const auto deformer = frames.bound();
    Deformer::Drag drag(*deformer, PositionsView(frames.mesh.vertices));
    Positions last;
    for (std::size_t frame = 0; frame < 4; ++frame)
        last = solve_next(drag, frames.frames[frame]).vertices;
    Execution cancelled;
    cancelled.cancel_at_check(20);
    EXPECT_THROW(drag.solve(frames.frames[5], {}, cancelled), Cancelled);
    const Solution next = solve_next(drag, frames.frames[4]);
    EXPECT_LT(next.iterations, solve_from(*deformer, frames.frames[4], last).iterations);  // it remembers
}

TEST(SideBySide, ASettlingSolveThatIsCancelledInItsSecondHalfLeavesTheDragAsItWas) {
    const Drag frames(0.05, 5);
    const auto deformer = frames.bound();
    Deformer::Drag drag(*deformer, PositionsView(frames.mesh.vertices));
    Deformer::Drag undisturbed(*deformer, PositionsView(frames.mesh.vertices));
    Positions shape;
    for (std::size_t frame = 0; frame < 4; ++frame) {
        solve_next(undisturbed, frames.frames[frame]);
        shape = solve_next(drag, frames.frames[frame]).vertices;
    }
    const Solution expected = solve_next(undisturbed, frames.frames[4]);
    SolveOptions settling;
    settling.settle = true;
    // The last check of such a solve; most are of the second half, which is from rest.
    std::int64_t last = 1;
    for (std::int64_t step = 1 << 20; step > 0; step /= 2) {
        Execution cancelled;
        cancelled.cancel_at_check(last + step);
        try {
            deformer->solve(frames.frames[3], PositionsView(shape), settling, cancelled);
        } catch (const Cancelled&) {
            last += step;
        }
    }
    Execution cancelled;
    cancelled.cancel_at_check(last * 9 / 10);
    EXPECT_THROW(drag.solve(frames.frames[3], settling, cancelled), Cancelled);
    const Solution found = solve_next(drag, frames.frames[4]);
    EXPECT_EQ(found.initial_energy, expected.initial_energy);  // it begins where the frames before lead
    EXPECT_LT(largest_distance(found.vertices, expected.vertices), 1e-3 * frames.mesh.diagonal());
}

}  // namespace
}  // namespace meanvalue::tests
