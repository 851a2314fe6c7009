#include "meanvalue/common/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/fork.h"

namespace meanvalue {
namespace {

// How often a waiting thread asks before it sleeps, some 50 microseconds: within an iteration parallel calls follow
// each other closely, and waking a thread takes as long.
constexpr int kPatience = 4000;

// Bytes that have to be there before a thread begins: where it finds none for its own variables, glibc ends the
// process.
constexpr std::size_t kRoomOfThread = 1 << 20;

/// @throws std::exception if the system has no thread or no memory to spare.
template <typename Work>
void begin_thread(Work work) {
    ::operator delete(::operator new(kRoomOfThread));
    std::thread(std::move(work)).detach();
}

void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// Work for several threads, on its caller's stack. Changed under the pool's mutex alone.
struct Call {
    const std::function<void()>& work;  // of each thread
    int wanted;                         // threads that may still come
    std::atomic<int> helpers{0};        // that are at it
};

// Whether this thread is among those that ThreadPool::working_ counts: a call inside of a call adds none.
thread_local bool counts_as_working = false;

class ThreadPool {
  public:
    /// Calls `work` on this thread and on at most `most` others, idle ones or new ones. Returns when all are done.
    void run(int most, const std::function<void()>& work) {
        const bool is_outermost = !std::exchange(counts_as_working, true);
        Call call{work, most};
        std::unique_lock<std::mutex> lock(mutex_);
        working_ += is_outermost ? 1 : 0;
        offer(call);
        lock.unlock();
        work();
        lock.lock();
        calls_.erase(std::remove(calls_.begin(), calls_.end(), &call), calls_.end());
        has_calls_.store(!calls_.empty(), std::memory_order_relaxed);
        // Spins for a moment, then sleeps: helpers may take seconds longer than their caller.
        lock.unlock();
        for (int round = 0; round < kPatience && call.helpers.load(std::memory_order_relaxed) > 0; ++round)
            relax();
        lock.lock();
        done_.wait(lock, [&] { return call.helpers.load(std::memory_order_relaxed) == 0; });
        if (!is_outermost) return;
        counts_as_working = false;
        --working_;
        if (!calls_.empty()) awake_.notify_one();  // now there is room for one who helps another
    }

  private:
    /// Lets threads come, under the mutex.
    void offer(Call& call) {
        cores_ = std::max(cores_, call.wanted + 1);
        try {
            calls_.push_back(&call);
            int wanted = 0;
            for (const Call* each : calls_)
                wanted += each->wanted;
            for (; idle_ < wanted && threads_ + 1 < cores_; ++idle_, ++threads_)
                begin_thread([this] { serve(); });  // it sleeps until the process ends
        } catch (const std::exception&) {
            // The system has no thread or no memory to spare: fewer do it.
        }
        has_calls_.store(!calls_.empty(), std::memory_order_relaxed);
        for (int k = std::min(idle_, call.wanted); k > 0; --k)
            awake_.notify_one();
    }

    void serve() {
        prepare_thread();
        counts_as_working = true;
        for (;;) {
            for (int round = 0; round < kPatience && !has_calls_.load(std::memory_order_relaxed); ++round)
                relax();
            std::unique_lock<std::mutex> lock(mutex_);
            awake_.wait(lock, [&] { return !calls_.empty() && working_ < cores_; });
            Call& call = *calls_.back();  // the innermost
            if (--call.wanted == 0) calls_.pop_back();
            has_calls_.store(!calls_.empty(), std::memory_order_relaxed);
            --idle_;
            ++working_;
            ++call.helpers;
            lock.unlock();
            call.work();
            lock.lock();
            ++idle_;
            --working_;
            if (--call.helpers == 0) done_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable awake_;
    std::condition_variable done_;
    std::vector<Call*> calls_;  // that want more threads
    std::atomic<bool> has_calls_{false};
    int threads_ = 0;
    int idle_ = 0;     // of these
    int working_ = 0;  // callers, and the threads that help them
    int cores_ = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
};

}  // namespace

void run_on_pool(int workers, const std::function<void(int)>& work) {
    std::atomic<int> next{0};
    const std::function<void()> take = [&] {
        for (int worker = next++; worker < workers; worker = next++)
            work(worker);
    };
    if (workers > 1) {
        of_this_process<ThreadPool>().run(workers - 1, take);
    } else {
        take();
    }
}

void prepare_thread() {
    counts_as_working = false;
    static_cast<void>(std::uncaught_exceptions());
}

void start_thread(std::function<void()> work) {
    try {
        begin_thread([work = std::move(work)]() mutable {
            prepare_thread();
            work();
        });
    } catch (const std::exception& error) {
        throw SolverFailure(message("the system has no thread to spare (", error.what(), ")"));
    }
}

}  // namespace meanvalue
