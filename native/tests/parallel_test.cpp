#include "meanvalue/common/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#ifndef _WIN32
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "meanvalue/common/thread_pool.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
    for (const Index count : {0, 1, 2047, 2048, 2049, 100000}) {
        for (const int threads : {1, 2, 7}) {
            std::vector<int> visits(count, 0);
            parallel_for(count, threads, Execution(), [&](Index begin, Index end) {
                for (Index k = begin; k < end; ++k)
                    ++visits[k];
            });
            EXPECT_EQ(visits, std::vector<int>(count, 1));
        }
    }
}

TEST(ParallelFor, GivesTheFirstExceptionToTheCaller) {
    const auto fail_in_second_half = [](Index begin, Index) {
        if (begin >= 50000) throw std::logic_error(message(begin));
    };
    EXPECT_THROW(parallel_for(100000, 4, Execution(), fail_in_second_half), std::logic_error);
}

TEST(ParallelFor, StopsWhenCancelled) {
    Execution execution;
    std::atomic<int> pieces{0};
    const auto cancel_at_once = [&](Index, Index) {
        ++pieces;
        execution.cancel();
    };
    EXPECT_THROW(parallel_for(1 << 20, 2, execution, cancel_at_once), Cancelled);
    EXPECT_LE(pieces, 2);
}

int count_all(Index count, int threads) {
    std::atomic<int> sum{0};
    parallel_for(count, threads, Execution(), [&](Index begin, Index end) { sum += end - begin; });
    return sum;
}

TEST(RunWorkers, CallsEachWorkerOnceForAnyNumberOfThemInAnyOrder) {
    for (const int workers : {5, 1, 3, 8, 2, 8, 2}) {
        for (int repeat = 0; repeat < 300; ++repeat) {
            std::vector<std::atomic<int>> calls(workers);
            run_workers(workers, [&](int worker) { ++calls[worker]; });
            for (const std::atomic<int>& call : calls)
                ASSERT_EQ(call, 1);
        }
    }
}

/// Every member of a team of `outer` makes a team of `inner` while all others have theirs. Returns who worked.
int nested_members(int outer, int inner) {
    std::atomic<int> arrived{0};
    std::atomic<int> working{0};
    std::atomic<int> begun{0};
    run_team_on_pool(outer, [&](int, int members) {
        ++arrived;
        while (arrived < members)
            std::this_thread::yield();
        run_team_on_pool(inner, [&](int member, int) {
            ++working;
            if (member == 0) ++begun;
            while (begun < members)
                std::this_thread::yield();
        });
    });
    return working;
}

TEST(RunOnPool, CallsInsideOfCallsGetTheirShareOfAnyNumberOfCores) {
    for (const auto& [outer, inner] : {std::pair{4, 4}, std::pair{8, 8}}) {
        run_on_pool(outer * inner, [](int) {});  // so many threads may work from here on
        EXPECT_EQ(nested_members(outer, inner), outer * inner);
    }
}

#ifdef RUSAGE_THREAD
TEST(RunOnPool, ACallerSleepsWhileItsHelpersWorkOn) {
    // How often it went to sleep of its own accord: a busy machine takes the processor from those that spin, too.
    const auto sleeps = [] {
        rusage usage{};
        getrusage(RUSAGE_THREAD, &usage);
        return usage.ru_nvcsw;
    };
    long before = 0;
    run_team_on_pool(2, [&](int member, int) {
        if (member > 0) std::this_thread::sleep_for(std::chrono::milliseconds(300));
        if (member == 0) before = sleeps();
    });
    EXPECT_GT(sleeps(), before);
}
#endif

TEST(RunWorkers, CallsFromSeveralThreadsAtOnceAreDone) {
    std::atomic<int> sum{0};
    std::vector<std::thread> callers;
    callers.reserve(4);
    for (int k = 0; k < 4; ++k) {
        callers.emplace_back([&] {
            for (int repeat = 0; repeat < 200; ++repeat)
                sum += count_all(5000, 3);
        });
    }
    for (std::thread& caller : callers)
        caller.join();
    EXPECT_EQ(sum, 4 * 200 * 5000);
}

TEST(RunWorkers, WorksOnAfterAnException) {
    for (int failing = 0; failing < 3; ++failing) {
        const auto fail = [&](int worker) {
            if (worker == failing) throw std::logic_error("on purpose");
        };
        EXPECT_THROW(run_workers(3, fail), std::logic_error);
        EXPECT_EQ(count_all(9000, 3), 9000);
    }
}

#ifndef _WIN32
TEST(RunWorkers, WorksInAForkedProcess) {
    ASSERT_EQ(count_all(9000, 3), 9000);  // there are threads now, which a fork does not take along
    const pid_t child = fork();
    if (child == 0) _exit(count_all(9000, 3) == 9000 ? 0 : 1);
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
}
#endif

TEST(ParallelItems, CallsEachItemOnceAndNoWorkerTwiceAtOnce) {
    for (const int threads : {1, 2, 5}) {
        for (const std::size_t count : {0, 1, 3, 1000}) {
            std::vector<std::atomic<int>> calls(count);
            std::vector<std::atomic<int>> working(threads);
            parallel_items(count, threads, Execution(), [&](int worker, std::size_t item) {
                EXPECT_EQ(++working[worker], 1);
                ++calls[item];
                --working[worker];
            });
            for (const std::atomic<int>& call : calls)
                ASSERT_EQ(call, 1);
        }
    }
}

TEST(ParallelItems, NoneIsTakenAfterAnException) {
    std::atomic<int> begun{0};
    const auto work = [&](int, std::size_t item) {
        ++begun;
        if (item == 0) throw std::logic_error("on purpose");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    EXPECT_THROW(parallel_items(1000, 3, Execution(), work), std::logic_error);
    EXPECT_LT(begun, 500);
    EXPECT_EQ(count_all(9000, 3), 9000);
}

TEST(ParallelInTurn, LaterRangesSeeWhatEarlierOnesWrote) {
    // Long and short ranges in turn, and empty ones.
    std::vector<Index> bounds = {0};
    for (const Index length : {3000, 10, 0, 700, 5, 5, 20000, 1, 600, 600, 2, 0})
        bounds.push_back(bounds.back() + length);
    for (const int threads : {1, 2, 7}) {
        std::vector<Index> range_of(bounds.back(), -1);
        std::atomic<Index> done{0};
        parallel_in_turn(bounds, threads, Execution(), [&](Index begin, Index end) {
            const auto range = std::upper_bound(bounds.begin(), bounds.end(), begin) - bounds.begin() - 1;
            EXPECT_GE(done, bounds[range]);
            for (Index k = begin; k < end; ++k)
                range_of[k] = static_cast<Index>(range);
            done += end - begin;
        });
        EXPECT_EQ(done, bounds.back());
        for (std::size_t range = 0; range + 1 < bounds.size(); ++range) {
            for (Index k = bounds[range]; k < bounds[range + 1]; ++k)
                ASSERT_EQ(range_of[k], static_cast<Index>(range));
        }
    }
    parallel_in_turn({}, 2, Execution(), [](Index, Index) { FAIL(); });
    parallel_in_turn({0}, 2, Execution(), [](Index, Index) { FAIL(); });
}

TEST(ParallelInTurn, FailsAndCancelsWithoutWaitingForEver) {
    const std::vector<Index> bounds = {0, 5000, 5010, 20000, 40000};
    for (const int threads : {1, 3}) {
        const auto fail = [](Index begin, Index) {
            if (begin > 6000) throw std::logic_error("on purpose");
        };
        EXPECT_THROW(parallel_in_turn(bounds, threads, Execution(), fail), std::logic_error);
        Execution execution;
        EXPECT_THROW(parallel_in_turn(bounds, threads, execution, [&](Index, Index) { execution.cancel(); }),
                     Cancelled);
    }
}

TEST(ThreadCount, RefusesANegativeNumber) {
    EXPECT_GE(thread_count(0), 1);
    EXPECT_EQ(thread_count(3), 3);
    EXPECT_TRUE(contains(message_of<InvalidInput>([] { thread_count(-2); }), "-2"));
}

}  // namespace
}  // namespace meanvalue::tests
