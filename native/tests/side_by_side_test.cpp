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

    Positions next(Deformer& deformer, std::size_t frame, const Positions& start) const {
        return solve_from(deformer, frames[frame], start).vertices;
    }

    /// The shape after every frame, each from the one before.
    std::vector<Positions> run(Deformer& deformer) const {
        std::vector<Positions> shapes;
        for (std::size_t frame = 0; frame < frames.size(); ++frame)
            shapes.push_back(next(deformer, frame, frame == 0 ? mesh.vertices : shapes.back()));
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
    Positions at_one = one.mesh.vertices, at_other = at_one;
    for (std::size_t frame = 0; frame < one.frames.size(); ++frame) {
        at_one = one.next(*deformer, frame, at_one);
        at_other = other.next(*deformer, frame, at_other);
        solve(*deformer, other.frames[frame]);  // nor does a solve from rest
        EXPECT_EQ(at_one, expected_one[frame]) << frame;
        EXPECT_EQ(at_other, expected_other[frame]) << frame;
    }
}

TEST(SideBySide, ADragGoesOnWhereAFrameWasCancelled) {
    const Drag drag(0.1);
    const auto deformer = drag.bound();
    Positions at = drag.mesh.vertices;
    for (std::size_t frame = 0; frame < 4; ++frame)
        at = drag.next(*deformer, frame, at);
    Execution execution;
    std::thread cancelled([&] {
        try {
            SolveOptions endless;
            endless.tolerance = 1e-300;
            endless.max_iterations = 1000000;
            deformer->solve(drag.frames[5], PositionsView(at), endless, execution);
        } catch (const Cancelled&) {
        }
    });
    while (std::string(execution.stage()) != "solve")
        std::this_thread::yield();
    execution.cancel();
    // It waits for what the cancelled frame holds: what that remembers saves iterations.
    const Solution next = solve_from(*deformer, drag.frames[4], at);
    cancelled.join();
    const auto stranger = drag.bound();
    EXPECT_LT(next.iterations, solve_from(*stranger, drag.frames[4], at).iterations);
}

}  // namespace
}  // namespace meanvalue::tests
