#include "meanvalue/common/abandon.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// How often a waiting thread looks at the cancel flag.
constexpr std::chrono::milliseconds kPollInterval{10};

struct Job {
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    std::exception_ptr failure;

    /// @throws Cancelled as soon as that is asked for.
    void wait(const Execution& execution) {
        std::unique_lock<std::mutex> lock(mutex);
        while (!finished.wait_for(lock, kPollInterval, [&] { return done; }))
            execution.check();
    }
};

/// The work that was left behind last, of the whole process: threads of cancelled calls share the machine.
class Abandoned {
  public:
    std::shared_ptr<Job> get() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return job_;
    }
    void set(std::shared_ptr<Job> job) {
        const std::lock_guard<std::mutex> lock(mutex_);
        job_ = std::move(job);
    }

  private:
    std::mutex mutex_;
    std::shared_ptr<Job> job_;
};

Abandoned& abandoned() {
    // Never destroyed: a thread left behind may outlive static objects.
    static auto* const instance = new Abandoned;
    return *instance;
}

void start(const std::shared_ptr<Job>& job, const std::function<void()>& work) {
    try {
        std::thread([job, work] {
            std::exception_ptr failure;
            try {
                work();
            } catch (...) {
                failure = std::current_exception();
            }
            const std::lock_guard<std::mutex> lock(job->mutex);
            job->failure = failure;
            job->done = true;
            job->finished.notify_all();
        }).detach();
    } catch (const std::system_error& error) {
        throw SolverFailure(message("the system has no thread to spare (", error.what(), ")"));
    }
}

}  // namespace

void run_abandonable(const std::function<void()>& work, const Execution& execution) {
    execution.check();
    if (const std::shared_ptr<Job> left_behind = abandoned().get()) left_behind->wait(execution);
    const auto job = std::make_shared<Job>();
    start(job, work);
    try {
        job->wait(execution);
    } catch (const Cancelled&) {
        abandoned().set(job);
        throw;
    }
    if (job->failure) std::rethrow_exception(job->failure);
}

void wait_for_abandoned() {
    if (const std::shared_ptr<Job> left_behind = abandoned().get()) left_behind->wait(Execution());
}

}  // namespace meanvalue
