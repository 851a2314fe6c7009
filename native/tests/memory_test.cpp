// What happens where memory runs out.

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sys/resource.h>
#endif

#include "meanvalue/common/parallel.h"
#include "meanvalue/common/physical_memory.h"
#include "meanvalue/deform/binding_input.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/morph/morpher.h"
#include "meanvalue/sequence/sequence.h"
#include "tests/failing_allocations.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Runs `action` again and again, each time with a later allocation that fails, until it gets through. It may throw
/// std::bad_alloc, or a SolverFailure that says so. @return how often it did.
template <typename Action>
int failed_everywhere(const Action& action) {
    int failures = 0;
    for (std::int64_t count = 0;; count += 1 + count / 16) {
        const FailingAllocation failing(count);
        try {
            action();
        } catch (const std::bad_alloc&) {
            ++failures;
            continue;
        } catch (const SolverFailure& error) {
            EXPECT_TRUE(contains(error.what(), "too little memory")) << error.what();
            ++failures;
            continue;
        }
        if (!failing.has_failed()) return failures;  // else a thread was done without
    }
}

struct Bent {
    Mesh mesh = torus(14, 9);
    std::vector<Index> anchors = spread_vertices(mesh, 6);
    Positions targets = rows_of(mesh.vertices, anchors);

    Bent() { targets.row(2) += Eigen::RowVector3d(0.3, 0.2, 0.9); }
    Binding binding(Method method, int threads) const { return binding_of(mesh, anchors, method, threads); }
    Positions solved(Deformer& deformer) const {
        Execution execution;
        return deformer.solve(targets, {}, SolveOptions(), execution).vertices;
    }
};

TEST(Memory, WhatABindTakesIsToldWhereItIsMoreThanThereIs) {
    EXPECT_NO_THROW(require_memory(1000000, 4000000000));
    EXPECT_NO_THROW(require_memory(0, 0));
    const std::string refusal = message_of<TooLittleMemory>([] { require_memory(4000000, 8000000000); });
    EXPECT_TRUE(contains(refusal, "4000000 free vertices takes about 10.8 GB")) << refusal;
    EXPECT_TRUE(contains(refusal, "has 8 GB")) << refusal;
}

TEST(Memory, IsLimitedByGroupsOfProcesses) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "meanvalue_groups";
    const auto write = [&](const std::string& file, const std::string& text) {
        std::filesystem::create_directories((folder / file).parent_path());
        std::ofstream(folder / file) << text;
        return (folder / file).string();
    };
    constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
    const std::string fresh = write("new", "0::/a/b\n");
    EXPECT_EQ(group_memory(fresh, folder.string()), kNoLimit);
    write("a/b/memory.max", "max\n");
    write("a/memory.max", "5000\n");
    EXPECT_EQ(group_memory(fresh, folder.string()), 5000u);
    write("memory.max", "4000\n");
    EXPECT_EQ(group_memory(fresh, folder.string()), 4000u);
    write("memory/memory.limit_in_bytes", "3000\n");
    const std::string old = write("old", "3:cpu,cpuacct:/c\n2:memory:/elsewhere/c\n0::/\n");
    EXPECT_EQ(group_memory(old, folder.string()), 3000u);
    EXPECT_EQ(group_memory("/nowhere", folder.string()), kNoLimit);
    std::filesystem::remove_all(folder);
}

TEST(Memory, IsWhatTheBindingSays) {
    const Mesh tube = capped_tube(8, 12, 4.0);
    Binding binding(tube.vertices, tube.faces, {0});
    binding.memory = 1000;
    EXPECT_THROW(Deformer{binding}, TooLittleMemory);
    binding.memory = 1000000000;
    EXPECT_NO_THROW(Deformer{binding});
}

TEST(Memory, OfThisComputerIsKnown) {
    EXPECT_GT(physical_memory(), 100000000U);
    EXPECT_LT(physical_memory(), std::uint64_t{1} << 50);
}

class RunsOut : public testing::TestWithParam<Method> {
  protected:
    void SetUp() override {
        if (!FailingAllocation::is_there()) GTEST_SKIP() << "sanitizers have an operator new of their own";
    }
};

TEST_P(RunsOut, BindAndSolveEndByNameAndTheNextHaveTheSameBits) {
    const Bent bent;
    for (const int threads : {1, 2}) {
        Execution execution;
        const Binding binding = bent.binding(GetParam(), threads);
        Deformer deformer(binding, execution);
        const Positions expected = bent.solved(deformer);
        EXPECT_GT(failed_everywhere([&] { const Deformer other(binding, execution); }), 20);
        EXPECT_GT(failed_everywhere([&] { bent.solved(deformer); }), 5);
        EXPECT_EQ(bent.solved(deformer), expected) << threads << " threads";
    }
}

INSTANTIATE_TEST_SUITE_P(Methods, RunsOut, testing::Values(Method::kFast, Method::kPaper, Method::kFull));

TEST(Memory, ThatRunsOutCostsThePoolNoThread) {
    if (!FailingAllocation::is_there()) GTEST_SKIP() << "sanitizers have an operator new of their own";
    for (int caller = 0; caller <= thread_count(0); ++caller) {
        std::thread([] {
            for (int count = 0; count < 6; ++count) {
                const FailingAllocation failing(count);
                try {
                    run_workers(2, [](int) {});
                } catch (const std::bad_alloc&) {
                }
            }
        }).join();
    }
    std::atomic<int> begun{0};
    run_workers(2, [&](int) {
        ++begun;
        for (int round = 0; round < 2000 && begun < 2; ++round)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_EQ(begun, 2) << "both run at the same time";
    });
}

TEST(Memory, RunsOutInClipsAndMorphs) {
    if (!FailingAllocation::is_there()) GTEST_SKIP() << "sanitizers have an operator new of their own";
    const Bent bent;
    Execution execution;
    Deformer deformer(bent.binding(Method::kFast, 2), execution);
    Trajectories clip;
    clip.frame_count = 6;
    clip.anchor_count = static_cast<Index>(bent.anchors.size());
    for (Index frame = 0; frame < clip.frame_count; ++frame)
        clip.targets.insert(clip.targets.end(), bent.targets.data(), bent.targets.data() + bent.targets.size());
    SequenceOptions options;
    options.chunk = 3;
    options.overlap = 2;
    options.threads = 2;
    EXPECT_GT(failed_everywhere([&] { solve_sequence(deformer, clip, options, execution); }), 10);

    const Positions other = 1.5 * bent.mesh.vertices;
    const MorphBinding shapes(std::vector<Positions>{bent.mesh.vertices, other}, bent.mesh.faces);
    EXPECT_GT(failed_everywhere([&] { const Morpher morpher(shapes, execution); }), 20);
    const Morpher morpher(shapes, execution);
    const Positions expected = morpher.solve({0.5, 0.5}, {}, execution).vertices;
    EXPECT_GT(failed_everywhere([&] { morpher.solve({0.5, 0.5}, {}, execution); }), 5);
    EXPECT_EQ(morpher.solve({0.5, 0.5}, {}, execution).vertices, expected);
}

#ifdef __linux__
/// As long as this lives, the process has room for `spare` more blocks of `size` floats, and for no others. Unlike
/// FailingAllocation, it also holds for Eigen's matrices.
class NoRoom {
  public:
    NoRoom(std::size_t spare, std::size_t size) {
        blocks_.reserve(std::size_t{1} << 20);
        getrlimit(RLIMIT_AS, &before_);
        std::size_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        rlimit now = before_;
        now.rlim_cur = pages * 4096;
        setrlimit(RLIMIT_AS, &now);
        try {
            for (;;)
                blocks_.emplace_back(size);
        } catch (const std::bad_alloc&) {
        }
        blocks_.resize(blocks_.size() - std::min(spare, blocks_.size()));
    }
    NoRoom(const NoRoom&) = delete;
    NoRoom& operator=(const NoRoom&) = delete;
    ~NoRoom() { setrlimit(RLIMIT_AS, &before_); }

  private:
    rlimit before_ = {};
    std::vector<std::vector<float>> blocks_;
};

TEST(Memory, ThatRunsOutForMoreGapsOfADragIsToldAndItGoesOn) {
    if (!FailingAllocation::is_there()) GTEST_SKIP() << "sanitizers take memory of their own";
    const Mesh tube = capped_tube(50, 1200, 60.0);
    std::vector<Index> anchors;
    for (Index vertex = 0; vertex < tube.vertices.rows(); ++vertex) {
        if (std::abs(tube.vertices(vertex, 2) - 30.0) > 29.7) anchors.push_back(vertex);
    }
    ASSERT_GT(anchors.size(), 250U);
    Binding binding = binding_of(tube, anchors, Method::kFast, 1);
    binding.strengths.assign(anchors.size(), 10.0);
    Execution execution;
    const Deformer deformer(binding, execution);
    Deformer::Drag drag(deformer);
    const auto solved = [&](std::ptrdiff_t gaps) {
        SolveOptions options;
        options.weights.assign(anchors.size(), 1.0);
        std::fill_n(options.weights.begin(), gaps, 0.0);
        return drag.solve(rows_of(tube.vertices, anchors), options, execution).vertices;
    };
    solved(10);
    solved(60);
    int refused = 0;
    for (const std::size_t spare : {1, 20, 60, 120}) {
        const auto size = static_cast<std::size_t>(tube.vertices.rows());
        try {
            const NoRoom none(spare, size);
            solved(250);
        } catch (const std::bad_alloc&) {
            ++refused;
        } catch (const SolverFailure& error) {
            EXPECT_TRUE(contains(error.what(), "too little memory")) << error.what();
            ++refused;
        }
        EXPECT_LT(largest_distance(solved(60), tube.vertices), 1e-6) << spare;
    }
    EXPECT_GT(refused, 0);
}
#endif

}  // namespace
}  // namespace meanvalue::tests
