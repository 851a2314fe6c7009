#include "meanvalue/common/detached_job.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/fork.h"
#include "meanvalue/common/thread_pool.h"

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

/// The work that was left behind and may still run, of the whole process: threads of cancelled calls share the
/// machine. One call may leave several pieces: work that itself waits for work.
class LeftBehind {
  public:
    void add(std::shared_ptr<Job> job) {
        const std::lock_guard<std::mutex> lock(mutex_);
        jobs_.push_back(std::move(job));
    }

    /// @throws Cancelled; then what still runs stays known.
    void wait(const Execution& execution) {
        while (const std::shared_ptr<Job> job = last()) {
            job->wait(execution);
            const std::lock_guard<std::mutex> lock(mutex_);
            jobs_.erase(std::remove(jobs_.begin(), jobs_.end(), job), jobs_.end());
        }
    }

  private:
    std::shared_ptr<Job> last() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return jobs_.empty() ? nullptr : jobs_.back();
    }

    std::mutex mutex_;
    std::vector<std::shared_ptr<Job>> jobs_;
};

/// In a forked child there is nothing to wait for.
LeftBehind& left_behind() {
    return of_this_process<LeftBehind>();
}

void start(const std::shared_ptr<Job>& job, const std::function<void()>& work) {
    start_on_pool([job, work = std::function<void()>(work)]() mutable {
        std::exception_ptr failure;
        try {
            work();
        } catch (...) {
            failure = std::current_exception();
        }
        work = nullptr;  // what it owns is part of it: freeing gigabytes takes a while
        const std::lock_guard<std::mutex> lock(job->mutex);
        job->failure = failure;
        job->done = true;
        job->finished.notify_all();
    });
}

}  // namespace

void run_detached(const std::function<void()>& work, const Execution& execution) {
    execution.check();
    left_behind().wait(execution);
    const auto job = std::make_shared<Job>();
    start(job, work);
    try {
        job->wait(execution);
    } catch (const Cancelled&) {
        left_behind().add(job);
        throw;
    }
    if (job->failure) std::rethrow_exception(job->failure);
}

void wait_for_detached() {
    left_behind().wait(Execution());
}

}  // namespace meanvalue
