#include "meanvalue/sequence/sequence.h"

#include <gtest/gtest.h>

#include <limits>

#include "meanvalue/common/errors.h"
#include "meanvalue/sequence/run_plan.h"
#include "meshes.h"

namespace meanvalue::tests {
namespace {

struct Clip {
    Mesh tube = capped_tube(8, 12, 4.0);
    Deformer deformer{Binding(tube.vertices, tube.faces, {0, 40, 90})};

    /// All at rest, but for those from `begin` to `end`, whose targets are no numbers.
    Trajectories trajectories(Index frames, Index begin, Index end) const {
        Trajectories result;
        result.frame_count = frames;
        result.anchor_count = 3;
        for (Index frame = 0; frame < frames; ++frame) {
            const Positions targets = tube.vertices(std::vector<Index>{0, 40, 90}, Eigen::all);
            result.targets.insert(result.targets.end(), targets.data(), targets.data() + targets.size());
        }
        std::fill(result.targets.begin() + 9 * begin, result.targets.begin() + 9 * end,
                  std::numeric_limits<double>::quiet_NaN());
        return result;
    }
};

TEST(Sequence, FramesThatCannotBeSolvedAreNotSolvedAgainForEachRun) {
    const Clip clip;
    SequenceOptions options;
    options.chunk = 4;
    options.overlap = 2;
    for (const Index begin : {0, 10}) {
        const Trajectories trajectories = clip.trajectories(500, begin, 450);
        Execution execution;
        const RunPlan plan = plan_runs(clip.deformer.bound(), trajectories, options, execution);
        for (const auto& run : plan.runs) {
            EXPECT_LE(run.end - run.begin, options.chunk + options.overlap + kFramesOfSnap);
            const bool is_after_a_gap = run.begin >= begin && run.begin < 450;
            EXPECT_EQ(run.lead, is_after_a_gap ? begin - 1 : -1);
        }
        const Sequence solved = solve_sequence(clip.deformer, trajectories, options, execution);
        EXPECT_EQ(solved.failures.size(), 450u - begin);
    }
}

TEST(Sequence, TrajectoriesOfOtherSizesAreRefused) {
    const Clip clip;
    const Trajectories whole = clip.trajectories(5, 0, 0);
    std::vector<Trajectories> wrong(5, whole);
    wrong[0].targets.clear();
    wrong[1].targets.pop_back();
    wrong[2].weights = {1.0, 1.0, 1.0};
    wrong[3].frame_count = -1;
    wrong[4].frame_count = std::numeric_limits<Index>::max();
    Execution execution;
    EXPECT_NO_THROW(solve_sequence(clip.deformer, whole, {}, execution));
    for (const Trajectories& each : wrong)
        EXPECT_THROW(solve_sequence(clip.deformer, each, {}, execution), InvalidInput);
}

}  // namespace
}  // namespace meanvalue::tests
