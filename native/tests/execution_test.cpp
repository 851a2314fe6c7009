#include "meanvalue/common/execution.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "meanvalue/common/detached_job.h"
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

TEST(Execution, CancelsItselfAtTheLookAskedFor) {
    Execution execution;
    execution.cancel_at_look(3);
    EXPECT_NO_THROW(execution.check());
    EXPECT_NO_THROW(execution.check());
    EXPECT_FALSE(execution.cancelled());
    EXPECT_THROW(execution.check(), Cancelled);
    EXPECT_TRUE(execution.cancelled());
}

TEST(WorkMeter, LooksByTheWorkDone) {
    Execution execution;
    WorkMeter work(execution);
    execution.cancel();
    EXPECT_NO_THROW(work.add(1000));
    EXPECT_THROW(work.add(10'000'000), Cancelled);
    EXPECT_NO_THROW(work.add(1000));
}

TEST(DetachedJob, ReturnsWhatTheWorkDidAndThrowsWhatItThrew) {
    const auto done = std::make_shared<bool>(false);
    run_detached([done] { *done = true; }, Execution());
    EXPECT_TRUE(*done);
    EXPECT_THROW(run_detached([] { throw SolverFailure("no"); }, Execution()), SolverFailure);
}

/// Work that goes on until it is released, and a cancel that comes once it has begun.
struct EndlessWork {
    std::shared_ptr<std::atomic<bool>> begun = std::make_shared<std::atomic<bool>>(false);
    std::shared_ptr<std::atomic<bool>> release = std::make_shared<std::atomic<bool>>(false);
    std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);

    /// Runs it and cancels it; it is left behind.
    void leave_behind() const {
        Execution execution;
        std::thread canceller([&] {
            while (!*begun)
                std::this_thread::yield();
            execution.cancel();
        });
        const auto work = [begun = begun, release = release, ended = ended] {
            *begun = true;
            while (!*release)
                std::this_thread::yield();
            *ended = true;
        };
        EXPECT_THROW(run_detached(work, execution), Cancelled);  // would hang where it waited
        canceller.join();
    }
};

TEST(DetachedJob, ACancelDoesNotWaitForTheWork) {
    const EndlessWork work;
    work.leave_behind();
    EXPECT_FALSE(*work.ended);
    *work.release = true;
    wait_for_detached();
    EXPECT_TRUE(*work.ended);
}

TEST(DetachedJob, LeavesNoMoreThanOnePieceOfWorkBehind) {
    const EndlessWork work;
    work.leave_behind();
    // The next one waits for it, and can be cancelled while it does.
    Execution execution;
    const auto begun = std::make_shared<std::atomic<bool>>(false);
    std::thread canceller([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        execution.cancel();
    });
    EXPECT_THROW(run_detached([begun] { *begun = true; }, execution), Cancelled);
    canceller.join();
    EXPECT_FALSE(*begun);
    *work.release = true;
    wait_for_detached();
    run_detached([begun] { *begun = true; }, Execution());
    EXPECT_TRUE(*begun);
}

TEST(DetachedJob, WorkMayItselfLeaveWorkBehind) {
    const EndlessWork inner;
    const auto execution = std::make_shared<Execution>();
    std::thread canceller([&] {
        while (!*inner.begun)
            std::this_thread::yield();
        execution->cancel();
    });
    const auto outer = [execution, begun = inner.begun, release = inner.release, ended = inner.ended] {
        const auto endless = [begun, release, ended] {
            *begun = true;
            while (!*release)
                std::this_thread::yield();
            *ended = true;
        };
        run_detached(endless, *execution);
    };
    EXPECT_THROW(run_detached(outer, *execution), Cancelled);
    canceller.join();
    EXPECT_FALSE(*inner.ended);
    *inner.release = true;
    wait_for_detached();
    EXPECT_TRUE(*inner.ended);
}

/// Takes long to free.
struct Heavy {
    explicit Heavy(std::atomic<bool>& freed) : freed_(freed) {}
    ~Heavy() {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        freed_ = true;
    }
    std::atomic<bool>& freed_;
};

TEST(DetachedJob, WorkLeftBehindFreesWhatItOwnsBeforeItIsDone) {
    std::atomic<bool> freed{false};
    const EndlessWork endless;
    {
        const std::function<void()> work = [heavy = std::make_shared<Heavy>(freed), begun = endless.begun,
                                            release = endless.release] {
            *begun = true;
            while (!*release)
                std::this_thread::yield();
        };
        Execution execution;
        std::thread canceller([&] {
            while (!*endless.begun)
                std::this_thread::yield();
            execution.cancel();
        });
        EXPECT_THROW(run_detached(work, execution), Cancelled);
        canceller.join();
    }
    EXPECT_FALSE(freed);
    *endless.release = true;
    wait_for_detached();
    EXPECT_TRUE(freed);
}

}  // namespace
}  // namespace meanvalue::tests
