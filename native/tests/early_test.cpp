// What can be posed while a mesh is still being bound.
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/deform/deformer.h"
#include "tests/fast_poses.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Receiver = std::function<void(std::shared_ptr<Deformer>)>;

/// A tube that is bent, and what was early of its binding.
struct EarlyBend {
    Mesh mesh;
    std::vector<Index> anchors;
    std::shared_ptr<Deformer> early;
    std::unique_ptr<Deformer> whole;

    EarlyBend(Mesh tube, int threads, Method method = Method::kFast, const std::vector<double>& strengths = {})
        : mesh(std::move(tube)), anchors(bend("", mesh, 0.1).anchors) {
        Binding binding = binding_of(mesh, anchors, method, threads);
        if (!strengths.empty()) binding.strengths.assign(anchors.size(), strengths.front());
        Execution execution;
        whole = std::make_unique<Deformer>(binding, execution, nullptr,
                                           [&](std::shared_ptr<Deformer> coarse) { early = std::move(coarse); });
    }

    Positions at(double angle_rad) const { return bend("", mesh, angle_rad).targets; }
};

double rms(const Positions& a, const Positions& b) {
    return (a - b).norm() / std::sqrt(static_cast<double>(a.rows()));
}

/// With one coarse level, and with two.
std::vector<Mesh> tubes() {
    return {capped_tube(40, 60, 8.0), capped_tube(110, 200, 8.0)};
}

TEST(Early, ItIsNearTheWholeSolution) {
    for (const Mesh& tube : tubes()) {
        EarlyBend bent(tube, 2);
        ASSERT_TRUE(bent.early);
        const Positions whole = solve(*bent.whole, bent.at(0.8)).vertices;
        bent.whole.reset();  // it keeps what it needs
        const Positions early = solve(*bent.early, bent.at(0.8)).vertices;
        EXPECT_LT(rms(early, whole), 0.1 * rms(whole, bent.mesh.vertices));
        EXPECT_EQ(bent.early->report().anchor_count, static_cast<Index>(bent.anchors.size()));
    }
}

TEST(Early, ARestPoseStaysAtRest) {
    for (const Mesh& tube : tubes()) {
        const EarlyBend bent(tube, 1);
        const Positions rest = rows_of(bent.mesh.vertices, bent.anchors);
        EXPECT_LT(largest_distance(solve(*bent.early, rest).vertices, bent.mesh.vertices),
                  1e-9 * bent.mesh.diagonal());
    }
}

TEST(Early, ItIsTheSameForAnyNumberOfThreadsAndTheWholeIsAsWithoutIt) {
    for (const Mesh& tube : tubes()) {
        const EarlyBend one(tube, 1);
        const EarlyBend three(tube, 3);
        EXPECT_EQ(solve(*one.early, one.at(0.8)).vertices, solve(*three.early, one.at(0.8)).vertices);
        const auto alone = bound(binding_of(tube, one.anchors, Method::kFast, 1));
        EXPECT_EQ(solve(*one.whole, one.at(0.8)).vertices, solve(*alone, one.at(0.8)).vertices);
    }
}

TEST(Early, ARowOfSolvesGoesOnFromTheLastAndHasNoDrafts) {
    const EarlyBend bent(capped_tube(110, 200, 8.0), 2);
    Deformer::Drag drag(*bent.early);
    Positions last;
    for (int frame = 1; frame <= 4; ++frame) {
        last = solve_next(drag, bent.at(0.2 * frame)).vertices;
        EXPECT_FALSE(drag.draft(bent.at(0.2 * frame + 0.1)));
    }
    const Positions whole = solve(*bent.whole, bent.at(0.8)).vertices;
    EXPECT_LT(rms(last, whole), 0.1 * rms(whole, bent.mesh.vertices));
}

TEST(Early, SoftAnchorsMayGiveWayAndBeFree) {
    for (const Mesh& tube : tubes()) {
        const EarlyBend bent(tube, 2, Method::kFast, {10.0});
        const auto both = [&](const SolveOptions& options) {
            const Positions early = solve(*bent.early, bent.at(0.8), options).vertices;
            const Positions whole = solve(*bent.whole, bent.at(0.8), options).vertices;
            EXPECT_LT(rms(early, whole), 0.15 * rms(whole, bent.mesh.vertices));
        };
        both({});
        SolveOptions options;
        options.weights.assign(bent.anchors.size(), 1.0);
        for (std::size_t k = 0; k < bent.anchors.size(); k += 3)
            options.weights[k] = 0.0;
        both(options);
    }
}

TEST(Early, ThereIsNoneWithoutCoarseLevels) {
    EXPECT_FALSE(EarlyBend(capped_tube(16, 20, 8.0), 1).early);
    EXPECT_FALSE(EarlyBend(capped_tube(40, 60, 8.0), 1, Method::kPaper).early);
}

/// Binds a tube, and solves early on two threads beside until the whole is bound or has failed. Returns whether each
/// had the same bits whenever it solved.
bool solve_beside(Execution& execution, const std::function<void()>& when_solved) {
    const Mesh tube = capped_tube(110, 200, 8.0);
    const Pose pose = bend("", tube, 0.8);
    const Binding binding = binding_of(tube, pose.anchors, Method::kFast, 2);
    std::atomic<bool> ends{false};
    std::atomic<bool> is_same{true};
    std::vector<std::thread> others;
    const auto begin_to_solve = [&](const std::shared_ptr<Deformer>& early) {
        for (int k = 0; k < 2; ++k) {
            others.emplace_back([&, early] {
                const Positions first = solve(*early, pose.targets).vertices;
                when_solved();
                do {
                    if (solve(*early, pose.targets).vertices != first) is_same = false;
                } while (!ends);
            });
        }
    };
    try {
        const Deformer whole(binding, execution, nullptr, begin_to_solve);
    } catch (const Cancelled&) {
    }
    ends = true;
    for (std::thread& other : others)
        other.join();
    EXPECT_EQ(others.size(), 2u);
    return is_same;
}

TEST(Early, ItIsSolvedByTwoWhileTheWholeIsBound) {
    Execution execution;
    EXPECT_TRUE(solve_beside(execution, [] {}));
}

TEST(Early, ItIsSolvedByTwoWhileTheWholeIsCancelled) {
    Execution execution;
    EXPECT_TRUE(solve_beside(execution, [&] { execution.cancel(); }));
}

TEST(Early, WhatItsReceiverThrowsEndsTheBinding) {
    const Mesh tube = capped_tube(40, 60, 8.0);
    const Binding binding = binding_of(tube, bend("", tube, 0.1).anchors, Method::kFast, 2);
    Execution execution;
    const Receiver fails = [](const std::shared_ptr<Deformer>&) { throw std::bad_alloc(); };
    EXPECT_THROW(Deformer(binding, execution, nullptr, fails), std::bad_alloc);
}

}  // namespace
}  // namespace meanvalue::tests
