#include "meanvalue/common/abandon.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace meanvalue {
namespace {

// How often a waiting thread looks at the cancel flag.
constexpr std::chrono::milliseconds kPollInterval{10};

struct Job {
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    std::exception_ptr failure;
};

}  // namespace

void run_abandonable(const std::function<void()>& work, const Execution& execution) {
    execution.check();
    const auto job = std::make_shared<Job>();
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

    std::unique_lock<std::mutex> lock(job->mutex);
    while (!job->finished.wait_for(lock, kPollInterval, [&] { return job->done; }))
        execution.check();
    if (job->failure) std::rethrow_exception(job->failure);
}

}  // namespace meanvalue
