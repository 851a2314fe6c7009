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

TEST(ParallelFor, WakesNoThreadForLessThanAPiece) {
    std::atomic<int> elsewhere{0};
    const auto here = std::this_thread::get_id();
    for (int repeat = 0; repeat < 20; ++repeat) {
        parallel_for(2 * kPiece - 1, 2, Execution(), [&](Index, Index) {
            if (std::this_thread::get_id() != here) ++elsewhere;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        });
    }
    EXPECT_EQ(elsewhere, 0);
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

/// Waits until `count` has reached `wanted`, or a busy machine has had its chance to get there.
void wait_for(const std::atomic<int>& count, int wanted) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (count < wanted && std::chrono::steady_clock::now() < end)
        std::this_thread::yield();
}

/// Each of `outer` workers calls `inner` workers while all others have theirs. Returns how many worked at once.
int nested_workers(int outer, int inner) {
    std::atomic<int> begun{0};
    std::atomic<int> working{0};
    run_on_pool(outer, [&](int) {
        ++begun;
        wait_for(begun, outer);
        run_on_pool(inner, [&](int) {
            ++working;
            wait_for(working, outer * inner);
        });
    });
    return working;
}

TEST(RunOnPool, CallsInsideOfCallsGetTheirShareOfAnyNumberOfCores) {
    for (const auto& [outer, inner] : {std::pair{4, 4}, std::pair{8, 8}}) {
        run_on_pool(outer * inner, [](int) {});  // so many threads may work from here on
        const auto begin = std::chrono::steady_clock::now();
        EXPECT_EQ(nested_workers(outer, inner), outer * inner);
        // Who waits in vain for a worker that gets no thread waits for all of the time.
        EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
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
    std::atomic<int> begun{0};
    long before = 0;
    const auto caller = std::this_thread::get_id();  // either thread may be worker 0
    run_on_pool(2, [&](int) {
        ++begun;
        wait_for(begun, 2);
        if (std::this_thread::get_id() != caller)
            std::this_thread::sleep_for(std::chrono::milliseconds(300));
        else
            before = sleeps();
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

TEST(ThreadCount, RefusesANegativeNumber) {
    EXPECT_GE(thread_count(0), 1);
    EXPECT_EQ(thread_count(3), 3);
    EXPECT_LE(thread_count(1000000), std::max(8, thread_count(0)));
    EXPECT_TRUE(contains(message_of<InvalidInput>([] { thread_count(-2); }), "-2"));
}

}  // namespace
}  // namespace meanvalue::tests
