#include <gtest/gtest.h>

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/sequence/sequence.h"
#include "tests/meshes.h"

namespace meanvalue::tests {
namespace {

constexpr Index kFrames = 10;

/// One end of a tube turns, the other stays.
struct Clip {
    Mesh mesh = capped_tube(8, 6, 4.0);
    std::vector<Index> anchors = spread_vertices(mesh, 4);
    Trajectories trajectories{kFrames, 4, {}, {}};
    SequenceOptions options;

    Clip() {
        for (Index frame = 0; frame < kFrames; ++frame) {
            Positions targets = rows_of(mesh.vertices, anchors);
            targets.topRows(2).col(0).array() += 0.1 * frame;
            trajectories.targets.insert(trajectories.targets.end(), targets.data(), targets.data() + targets.size());
        }
        options.chunk = 4;
        options.overlap = 2;
        options.threads = 1;
        options.may_pause = true;
    }
};

std::vector<float> numbers_of(const Sequence& clip) {
    const float* begin = clip.vertices.get();
    return {begin, begin + static_cast<std::ptrdiff_t>(clip.frame_count) * clip.vertex_count * 3};
}

TEST(SequencePause, ByItselfAfterEachFrameItEndsInTheBitsOfTheWhole) {
    Clip clip;
    Execution execution;
    Deformer deformer({clip.mesh.vertices, clip.mesh.faces, clip.anchors, {}}, execution);
    const Sequence whole = solve_sequence(deformer, clip.trajectories, clip.options, execution);
    ASSERT_TRUE(whole.state.empty());
    int pauses = 0;
    for (clip.options.pause_after = 0;; ++clip.options.pause_after, ++pauses) {
        Sequence part = solve_sequence(deformer, clip.trajectories, clip.options, execution);
        if (part.state.empty()) {
            EXPECT_EQ(numbers_of(part), numbers_of(whole));
            EXPECT_EQ(part.energies, whole.energies);
            EXPECT_EQ(part.iterations, whole.iterations);
            break;
        }
        EXPECT_EQ(part.vertices, nullptr);
        EXPECT_LE(std::count(part.solved.begin(), part.solved.end(), 1), pauses);
        clip.options.resume = std::move(part.state);
    }
    EXPECT_GE(pauses, kFrames);  // runs go through frames before their own
}

TEST(SequencePause, OfRunsSideBySideItEndsInTheBitsOfTheWhole) {
    Clip clip;
    Execution execution;
    Deformer deformer({clip.mesh.vertices, clip.mesh.faces, clip.anchors, {}}, execution);
    const Sequence whole = solve_sequence(deformer, clip.trajectories, clip.options, execution);
    clip.options.threads = 3;
    int pauses = 0;
    for (clip.options.pause_after = 0;; ++clip.options.pause_after, ++pauses) {
        Sequence part = solve_sequence(deformer, clip.trajectories, clip.options, execution);
        if (part.state.empty()) {
            EXPECT_EQ(numbers_of(part), numbers_of(whole));
            EXPECT_EQ(part.energies, whole.energies);
            break;
        }
        clip.options.resume = std::move(part.state);
    }
    EXPECT_GE(pauses, kFrames / 3);
}

TEST(SequencePause, AMeshWithoutVerticesGoesOn) {
    Clip clip;
    Execution execution;
    const Positions nothing(0, 3);
    const Triangles no_faces(0, 3);
    Deformer deformer({nothing, no_faces, {}, {}}, execution);
    clip.trajectories = {kFrames, 0, {}, {}};
    for (clip.options.pause_after = 0; clip.options.pause_after < kFrames; clip.options.pause_after += 3) {
        Sequence part = solve_sequence(deformer, clip.trajectories, clip.options, execution);
        EXPECT_FALSE(part.state.empty());
        clip.options.resume = std::move(part.state);
    }
    clip.options.may_pause = false;
    EXPECT_EQ(solve_sequence(deformer, clip.trajectories, clip.options, execution).frame_count, kFrames);
}

TEST(SequencePause, WhatWasKeptIsRefusedOnceAnyByteIsAnother) {
    Clip clip;
    Execution execution;
    Deformer deformer({clip.mesh.vertices, clip.mesh.faces, clip.anchors, {}}, execution);
    clip.options.pause_after = 6;
    const Archive::Bytes state = solve_sequence(deformer, clip.trajectories, clip.options, execution).state;
    ASSERT_FALSE(state.empty());
    for (std::size_t place = 0; place < state.size(); place += place < 1000 ? 1 : 97) {
        clip.options.resume = state;
        clip.options.resume[place] ^= 1U << place % 8;
        EXPECT_THROW(solve_sequence(deformer, clip.trajectories, clip.options, execution), InvalidInput);
        clip.options.resume = {state.begin(), state.begin() + static_cast<std::ptrdiff_t>(place)};
        if (place > 0) {
            EXPECT_THROW(solve_sequence(deformer, clip.trajectories, clip.options, execution), InvalidInput);
        }
    }
}

}  // namespace
}  // namespace meanvalue::tests
