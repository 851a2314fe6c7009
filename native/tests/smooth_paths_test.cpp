#include "meanvalue/sequence/smooth_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

constexpr Index kFrames = 60;
constexpr Index kWidth = 8;

/// Of each frame, with y and z at 0.
std::vector<std::vector<float>> path(const std::function<double(Index)>& x, std::size_t points = 1) {
    std::vector<std::vector<float>> frames(kFrames, std::vector<float>(3 * points, 0.0F));
    for (Index t = 0; t < kFrames; ++t) {
        for (std::size_t k = 0; k < points; ++k)
            frames[t][3 * k] = static_cast<float>(x(t));
    }
    return frames;
}

std::vector<float*> points_of(std::vector<std::vector<float>>& frames) {
    std::vector<float*> points;
    points.reserve(frames.size());
    for (auto& frame : frames)
        points.push_back(frame.data());
    return points;
}

std::vector<std::vector<float>> smoothed(std::vector<std::vector<float>> frames, double limit,
                                         std::vector<char> is_solved = std::vector<char>(kFrames, 1)) {
    const std::vector<double> limits(kFrames, limit);
    PathSmoother(std::move(is_solved), kWidth)
        .smooth(points_of(frames), frames.front().size() / 3, {limits, limits}, Execution());
    return frames;
}

double largest_second_difference(const std::vector<std::vector<float>>& frames) {
    double largest = 0.0;
    for (std::size_t t = 1; t + 1 < frames.size(); ++t)
        largest = std::max(largest, std::abs(double{frames[t + 1][0]} - 2.0 * frames[t][0] + frames[t - 1][0]));
    return largest;
}

double step(Index t) {
    return t < 31 ? 0.0 : 1.0;
}

TEST(SmoothPaths, AJumpIsSpreadOverTheFramesBesideIt) {
    const auto frames = smoothed(path(step), 0.0);
    EXPECT_LT(largest_second_difference(frames), 0.04);
    for (Index t = 0; t < kFrames; ++t) {
        if (t >= 2) EXPECT_NEAR(frames[t][0] + frames[61 - t][0], 1.0, 1e-6) << t;  // as far before it as behind
        if (std::abs(t - 30.5) > 2 * kWidth) EXPECT_EQ(frames[t][0], static_cast<float>(step(t))) << t;
    }
}

TEST(SmoothPaths, AJumpThatTakesSomeFramesIsSpreadAsAWhole) {
    const auto frames = smoothed(path([](Index t) {
                                     const double x[] = {0.3, 0.65, 1.05, 1.1};
                                     return t < 30 || t > 33 ? step(t) : x[t - 30];
                                 }),
                                 0.0);
    EXPECT_LT(largest_second_difference(frames), 0.05);
}

TEST(SmoothPaths, SteadyMotionKeepsItsBits) {
    const auto motion = path([](Index t) { return 3.0 + 0.25 * t - 0.0625 * t * t; });
    const auto frames = smoothed(motion, 1e-3);
    for (Index t = 2 * kWidth; t < kFrames - 2 * kWidth; ++t)
        EXPECT_EQ(frames[t], motion[t]) << t;
}

TEST(SmoothPaths, WhatIsAsRoughAsTheTargetsKeepsItsBits) {
    const auto motion = path([](Index t) { return 1e4 + std::sin(1.7 * t) + 0.3 * step(t); });
    Trajectories targets{kFrames + 5, 1, std::vector<double>(3 * 5, 0.0), {}};  // five frames before the run
    for (const auto& frame : motion)
        targets.targets.insert(targets.targets.end(), frame.begin(), frame.end());
    const PathSmoother smoother(std::vector<char>(kFrames, 1), kWidth);
    auto frames = motion;
    const auto points = points_of(frames);
    smoother.smooth(points, 1, smoother.roughness_of(targets, 5, {0}, points), Execution());
    EXPECT_EQ(frames, motion);
}

TEST(SmoothPaths, EndsStayWhereTheyAre) {
    for (const Index at : {1, 3, 57, 59}) {
        const auto motion = path([&](Index t) { return t < at ? 0.0 : 1.0; });
        const auto frames = smoothed(motion, 0.0);
        EXPECT_EQ(frames.front(), motion.front());
        EXPECT_EQ(frames.back(), motion.back());
    }
}

TEST(SmoothPaths, FramesThatWereNotSolvedTellNothing) {
    std::vector<char> is_solved(kFrames, 1);
    std::fill(is_solved.begin() + 29, is_solved.begin() + 31, 0);
    // The jump after frames that held the last shape.
    const auto motion = path(step);
    const auto frames = smoothed(motion, 0.0, is_solved);
    EXPECT_EQ(frames, motion);
}

TEST(SmoothPaths, AnchorsThatAreFreeTellNothingAndThoseThatComeBackTheirVertices) {
    auto frames = path(step, 3);
    for (Index t = 0; t < kFrames; ++t)
        frames[t][6] = t < 40 ? 0.0F : 5.0F;
    const auto points = points_of(frames);
    const double free = std::nan("");
    for (const bool comes_back : {false, true}) {
        Trajectories targets{kFrames, 3, {}, {}};
        for (Index t = 0; t < kFrames; ++t) {
            const bool is_back = comes_back && t >= 40;
            targets.targets.insert(targets.targets.end(), {step(t), 0.0, 0.0, free, free, free});
            targets.targets.insert(targets.targets.end(), {is_back ? 7.0 : free, 0.0, 0.0});
            targets.weights.insert(targets.weights.end(), {1.0, 0.0, is_back ? 1.0 : 0.0});
        }
        const auto roughness =
            PathSmoother(std::vector<char>(kFrames, 1), kWidth).roughness_of(targets, 0, {0, 1, 2}, points).wide;
        EXPECT_NEAR(*std::max_element(roughness.begin(), roughness.end()), comes_back ? 5.0 : 1.0, 0.2);
        EXPECT_TRUE(std::all_of(roughness.begin(), roughness.end(), [](double r) { return std::isfinite(r); }));
    }
}

TEST(SmoothPaths, PointsDoNotDependOnTheirNeighbours) {
    const auto alone = smoothed(path(step), 0.01);
    const auto many = smoothed(path(step, 200), 0.01);
    for (Index t = 0; t < kFrames; ++t) {
        for (std::size_t k = 0; k < 200; ++k)
            ASSERT_EQ(many[t][3 * k], alone[t][0]);
    }
}

TEST(SmoothPaths, IsCancelled) {
    Execution execution;
    execution.cancel();
    std::vector<float> numbers(3);
    const std::vector<double> limits(4, 0.0);
    EXPECT_THROW(
        PathSmoother({1, 1, 1, 1}, 2).smooth(std::vector<float*>(4, numbers.data()), 1, {limits, limits}, execution),
        Cancelled);
}

}  // namespace
}  // namespace meanvalue
