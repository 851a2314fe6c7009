#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/sequence/run_plan.h"

namespace meanvalue {
namespace {

constexpr Index kFrames = 60;
constexpr Index kMost = 8;

using Frames = std::vector<std::vector<float>>;

/// Of each frame, with y and z at 0.
Frames path(const std::function<double(Index)>& x, std::size_t points = 1) {
    Frames frames(kFrames, std::vector<float>(3 * points, 0.0F));
    for (Index t = 0; t < kFrames; ++t) {
        for (std::size_t k = 0; k < points; ++k)
            frames[t][3 * k] = static_cast<float>(x(t));
    }
    return frames;
}

RunPaths paths_of(Frames& frames, std::vector<char> is_solved = std::vector<char>(kFrames, 1)) {
    std::vector<float*> points;
    for (auto& frame : frames)
        points.push_back(frame.data());
    std::vector<Index> vertices(frames.front().size() / 3);
    std::iota(vertices.begin(), vertices.end(), 0);
    return {points, vertices, std::move(is_solved)};
}

Frames spread(Frames frames, double limit, const std::vector<Index>& staying = {}) {
    const std::vector<double> limits(kFrames, limit);
    std::vector<char> stays(kFrames, 0);
    for (const Index frame : staying)
        stays[frame] = 1;
    RunPaths paths = paths_of(frames);
    paths.spread(paths.find_snaps(limits, Execution()), limits, stays, kMost, Execution());
    return frames;
}

std::vector<Index> snaps_of(Frames frames, double limit = 1e-3) {
    std::vector<Index> result;
    for (const Snap& snap : paths_of(frames).find_snaps(std::vector<double>(kFrames, limit), Execution()))
        result.push_back(snap.frame);
    return result;
}

double largest_second_difference(const Frames& frames) {
    double largest = 0.0;
    for (std::size_t t = 1; t + 1 < frames.size(); ++t)
        largest = std::max(largest, std::abs(double{frames[t + 1][0]} - 2.0 * frames[t][0] + frames[t - 1][0]));
    return largest;
}

double step(Index t) {
    return t < 31 ? 0.0 : 1.0;
}

TEST(Snaps, OneIsSpreadOverTheFramesBesideIt) {
    const Frames frames = spread(path([](Index t) { return step(t) + 0.1 * t; }), 1e-3);
    EXPECT_LT(largest_second_difference(frames), 0.02);
    for (Index t = 0; t < kFrames; ++t) {
        if (std::abs(t - 30.5) > kMost) EXPECT_EQ(frames[t][0], static_cast<float>(step(t) + 0.1 * t)) << t;
    }
}

TEST(Snaps, OneThatTakesThreeStepsIsSpreadAsAWhole) {
    const Frames frames =
        spread(path([](Index t) { return t < 30 || t > 31 ? step(t) : (t == 30 ? 0.3 : 0.65); }), 1e-3);
    EXPECT_LT(largest_second_difference(frames), 0.02);
}

TEST(Snaps, ItTakesAsFewFramesAsMakeItAsSmoothAsTheTargets) {
    const Frames few = spread(path(step), 0.1);
    EXPECT_LT(largest_second_difference(few), 0.1);
    EXPECT_EQ(few[26][0], 0.0F);
    EXPECT_EQ(few[35][0], 1.0F);
}

TEST(Snaps, FramesThatStayKeepTheirBits) {
    const Frames frames = spread(path(step), 1e-3, {29, 33});
    EXPECT_EQ(frames[29][0], 0.0F);
    EXPECT_EQ(frames[33][0], 1.0F);
    EXPECT_LT(largest_second_difference(frames), 0.4);
    EXPECT_EQ(spread(path(step), 1e-3, {30, 31}), path(step));
}

TEST(Snaps, SteadyMotionAndSwingsAsOfTheTargetsAreNone) {
    EXPECT_TRUE(snaps_of(path([](Index t) { return 3.0 + 0.25 * t - 0.0625 * t * t; })).empty());
    EXPECT_TRUE(snaps_of(path([](Index t) { return std::sin(0.5 * t); }), 0.25).empty());
    EXPECT_EQ(snaps_of(path([](Index t) { return std::sin(0.2 * t) + step(t); }), 0.1), std::vector<Index>{31});
}

TEST(Snaps, SwingsThatAreFasterThanTheTargetsAreNone) {
    // Steps up to three times as large as those far from it, but of five frames: a limb that turns through.
    const auto turning = [](Index t) { return 0.04 * t + 0.12 * std::tanh(0.45 * (t - 30.5)); };
    EXPECT_EQ(snaps_of(path(turning)), std::vector<Index>());
    EXPECT_EQ(snaps_of(path([](Index t) { return 0.04 * t + 0.12 * step(t); })), std::vector<Index>{31});
}

TEST(Snaps, WhatTargetsAskForIsNone) {
    Frames motion = path([](Index t) { return 1e4 + 0.3 * step(t); });
    Trajectories targets{kFrames + 5, 2, {}, {}};  // five frames before the run, and an anchor that is free
    for (Index t = -5; t < kFrames; ++t) {
        targets.targets.insert(targets.targets.end(), {t < 0 ? 0.0 : motion[t][0], 0.0, 0.0, std::nan(""), 0.0, 0.0});
        targets.weights.insert(targets.weights.end(), {1.0, 0.0});
    }
    RunPaths paths = paths_of(motion);
    const std::vector<double> limits = paths.limits(targets, {{0, 0}, {1, 1}}, 5, 10.0);
    EXPECT_NEAR(limits[31], 0.301, 1e-3);
    EXPECT_NEAR(limits[20], 1e-3, 1e-9);
    EXPECT_TRUE(paths.find_snaps(limits, Execution()).empty());
    for (Index t = 25; t < kFrames; ++t)  // the anchor comes back
        targets.weights[2 * (t + 5) + 1] = 1.0;
    EXPECT_TRUE(std::isinf(paths.limits(targets, {{0, 0}, {1, 1}}, 5, 10.0)[25]));
}

TEST(Snaps, FramesThatWereNotSolvedTellNothing) {
    std::vector<char> is_solved(kFrames, 1);
    std::fill(is_solved.begin() + 29, is_solved.begin() + 31, char{0});
    Frames motion = path(step);  // the jump after frames that held the last shape
    EXPECT_TRUE(paths_of(motion, is_solved).find_snaps(std::vector<double>(kFrames, 1e-3), Execution()).empty());
}

TEST(Snaps, PointsDoNotDependOnTheirNeighbors) {
    const Frames alone = spread(path(step), 0.01);
    const Frames many = spread(path(step, 200), 0.01);
    for (Index t = 0; t < kFrames; ++t) {
        for (std::size_t k = 0; k < 200; ++k)
            ASSERT_EQ(many[t][3 * k], alone[t][0]);
    }
}

TEST(Snaps, AreCancelled) {
    Execution execution;
    execution.cancel();
    Frames frames = path(step);
    EXPECT_THROW(paths_of(frames).find_snaps(std::vector<double>(kFrames, 1.0), execution), Cancelled);
}

}  // namespace
}  // namespace meanvalue
