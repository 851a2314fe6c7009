// One bound mesh solved by several threads at once.
#include <thread>

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
        Execution execution;
        return std::make_unique<Deformer>(binding_of(mesh, anchors, method, threads), execution);
    }

    /// The shape after every frame, each from the one before.
    std::vector<Positions> run(Deformer& deformer) const {
        Deformer::Drag drag(deformer, PositionsView(mesh.vertices));
        std::vector<Positions> shapes;
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
        for (const Positions& targets : poses.frames)
            expected.push_back(solve(*deformer, targets).vertices);
        std::vector<std::vector<Positions>> found(4, std::vector<Positions>(poses.frames.size()));
        std::vector<std::thread> threads;
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

TEST(SideBySide, ADragGoesOnWhereAFrameWasCancelled) {
    const Drag frames(0.1);
    const auto deformer = frames.bound();
    Deformer::Drag drag(*deformer, PositionsView(frames.mesh.vertices));
    Positions last;
    for (std::size_t frame = 0; frame < 4; ++frame)
        last = solve_next(drag, frames.frames[frame]).vertices;
    Execution execution;
    std::thread cancelled([&] {
        SolveOptions endless;
        endless.tolerance = 1e-300;
        endless.max_iterations = 1000000;
        EXPECT_THROW(drag.solve(frames.frames[5], endless, execution), Cancelled);
    });
    while (std::string(execution.stage()) != "solve")
        std::this_thread::yield();
    execution.cancel();
    const Solution next = solve_next(drag, frames.frames[4]);  // waits for the cancelled one
    cancelled.join();
    EXPECT_LT(next.iterations, solve_from(*deformer, frames.frames[4], last).iterations);  // it remembers
}

}  // namespace
}  // namespace meanvalue::tests
