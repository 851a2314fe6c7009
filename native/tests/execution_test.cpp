#include "meanvalue/common/execution.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "meanvalue/common/abandon.h"
#include "meanvalue/common/errors.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

TEST(Execution, ChecksThrowOnceCancelled) {
    Execution execution;
    EXPECT_NO_THROW(execution.check());
    execution.begin_stage("encode");
    EXPECT_STREQ(execution.stage(), "encode");
    execution.cancel();
    EXPECT_THROW(execution.check(), Cancelled);
    EXPECT_THROW(execution.begin_stage("solve"), Cancelled);
    EXPECT_STREQ(execution.stage(), "encode");
}

TEST(Abandon, ReturnsWhatTheWorkDidAndThrowsWhatItThrew) {
    const auto done = std::make_shared<bool>(false);
    run_abandonable([done] { *done = true; }, Execution());
    EXPECT_TRUE(*done);
    EXPECT_THROW(run_abandonable([] { throw SolverFailure("no"); }, Execution()), SolverFailure);
}

TEST(Abandon, ACancelDoesNotWaitForTheWork) {
    Execution execution;
    const auto release = std::make_shared<std::atomic<bool>>(false);
    const auto started = std::make_shared<std::atomic<bool>>(false);
    const auto ended = std::make_shared<std::atomic<bool>>(false);
    const auto work = [release, started, ended] {
        *started = true;
        while (!*release)
            std::this_thread::yield();
        *ended = true;
    };
    std::thread canceller([&] {
        while (!*started)  // cancelled before, the work would never begin
            std::this_thread::yield();
        execution.cancel();
    });
    EXPECT_THROW(run_abandonable(work, execution), Cancelled);  // would hang where it waited
    EXPECT_FALSE(*ended);
    canceller.join();
    *release = true;
    while (!*ended)
        std::this_thread::yield();
}

TEST(Abandon, LeavesNoMoreThanOnePieceOfWorkBehind) {
    Execution first;
    const auto release = std::make_shared<std::atomic<bool>>(false);
    std::thread canceller([&] { first.cancel(); });
    EXPECT_THROW(run_abandonable(
                     [release] {
                         while (!*release)
                             std::this_thread::yield();
                     },
                     first),
                 Cancelled);
    canceller.join();
    // The next one waits for it, and can be cancelled while it does.
    Execution second;
    const auto begun = std::make_shared<std::atomic<bool>>(false);
    std::thread other([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        second.cancel();
    });
    EXPECT_THROW(run_abandonable([begun] { *begun = true; }, second), Cancelled);
    other.join();
    EXPECT_FALSE(*begun);
    *release = true;
    wait_for_abandoned();
    run_abandonable([begun] { *begun = true; }, Execution());
    EXPECT_TRUE(*begun);
}

}  // namespace
}  // namespace meanvalue::tests
