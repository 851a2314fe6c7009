#include "meanvalue/common/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
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

void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// Work for several threads, on its caller's stack.
struct Call {
    const std::function<void()>& work;  // of each thread
    std::atomic<int> unfinished{0};
    std::mutex mutex;
    std::condition_variable done;

    /// One member is done. Under the mutex, since the caller ends the call as soon as none is left.
    void finish_one() {
        const std::lock_guard<std::mutex> lock(mutex);
        if (unfinished.fetch_sub(1, std::memory_order_release) == 1) done.notify_one();
    }

    /// Spins for a moment, then sleeps: members may take seconds longer than their caller.
    void wait() {
        for (int round = 0; round < kPatience && unfinished.load(std::memory_order_acquire) > 0; ++round)
            relax();
        std::unique_lock<std::mutex> lock(mutex);
        done.wait(lock, [&] { return unfinished.load(std::memory_order_acquire) == 0; });
    }
};

// Whether this thread is among those that ThreadPool::working_ counts: a call inside of a call adds none.
thread_local bool counts_as_working = false;

class ThreadPool {
  public:
    /// Calls `work` on this thread and on at most `most` others, idle ones or new ones. Returns when all are done.
    void run(int most, const std::function<void()>& work) {
        const bool is_outermost = !std::exchange(counts_as_working, true);
        if (is_outermost) working_.fetch_add(1, std::memory_order_relaxed);
        Call call{work};
        const std::vector<Member*> sent = send(call, most);
        work();
        call_back(sent, call);
        if (!sent.empty()) call.wait();
        if (!is_outermost) return;
        counts_as_working = false;
        working_.fetch_sub(1, std::memory_order_relaxed);
    }

    void start(std::function<void()> work) {
        auto member = std::make_unique<Member>();
        member->detached = std::move(work);
        try {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (idle_.empty()) {
                start_thread(std::move(member));
            } else {
                Member* const known = idle_.back();
                idle_.pop_back();
                known->detached = std::move(member->detached);
                known->wake_up(detached_work());
            }
        } catch (const std::exception& error) {
            throw SolverFailure(message("the system has no thread to spare (", error.what(), ")"));
        }
    }

  private:
    /// A thread of the pool, and what it is sent to.
    struct Member {
        std::mutex mutex;
        std::condition_variable awake;
        std::atomic<Call*> sent_to{nullptr};  // and not begun yet
        std::function<void()> detached;       // where it is sent to detached_work()

        void wake_up(Call& call) {
            {
                const std::lock_guard<std::mutex> lock(mutex);
                sent_to.store(&call, std::memory_order_release);
            }
            awake.notify_one();
        }

        /// Waits to be sent.
        Call& wait() {
            Call* call = nullptr;
            const auto is_sent = [&] {
                return sent_to.load(std::memory_order_relaxed) != nullptr &&
                       (call = sent_to.exchange(nullptr, std::memory_order_acquire)) != nullptr;
            };
            for (int round = 0; round < kPatience; ++round) {
                if (is_sent()) return *call;
                relax();
            }
            std::unique_lock<std::mutex> lock(mutex);
            awake.wait(lock, is_sent);
            return *call;
        }
    };

    std::vector<Member*> send(Call& call, int most) {
        std::vector<Member*> sent;
        const std::lock_guard<std::mutex> lock(mutex_);
        cores_ = std::max(cores_, most + 1);
        // The caller counts already. Detached work counts only while it makes calls of its own.
        const int count = std::clamp(cores_ - working_.load(std::memory_order_relaxed), 0, most);
        while (static_cast<int>(sent.size()) < count) {
            try {
                sent.reserve(count);
                if (idle_.empty()) idle_.push_back(start_thread(std::make_unique<Member>()));
            } catch (const std::exception&) {
                break;  // the system has no thread or no memory to spare: fewer do it
            }
            Member* const member = idle_.back();
            idle_.pop_back();
            working_.fetch_add(1, std::memory_order_relaxed);
            call.unfinished.fetch_add(1, std::memory_order_relaxed);
            sent.push_back(member);
            member->wake_up(call);
        }
        return sent;
    }

    /// Takes the call back from members that have not begun it: no work is left for them.
    void call_back(const std::vector<Member*>& sent, Call& call) {
        for (Member* const member : sent) {
            Call* expected = &call;
            if (!member->sent_to.compare_exchange_strong(expected, nullptr)) continue;
            working_.fetch_sub(1, std::memory_order_relaxed);
            call.finish_one();
            const std::lock_guard<std::mutex> lock(mutex_);
            idle_.push_back(member);
        }
    }

    /// Under the mutex. A member with detached work begins with that.
    Member* start_thread(std::unique_ptr<Member> member) {
        idle_.reserve(threads_ + 1);  // so that a thread that is done always has a place
        Member* const known = member.get();
        if (known->detached) known->sent_to.store(&detached_work(), std::memory_order_relaxed);
        // Detached: they sleep until the process ends, and neither they nor the pool are ever destroyed.
        std::thread([this, known] { serve(*known); }).detach();
        ++threads_;
        return member.release();
    }

    void serve(Member& member) {
        prepare_thread();
        for (;;) {
            Call& call = member.wait();
            const bool is_detached = &call == &detached_work();
            if (is_detached) {
                member.detached();
                member.detached = nullptr;
            } else {
                counts_as_working = true;
                call.work();
                counts_as_working = false;
                working_.fetch_sub(1, std::memory_order_relaxed);
            }
            {
                const std::lock_guard<std::mutex> lock(mutex_);
                idle_.push_back(&member);
            }
            if (!is_detached) call.finish_one();
        }
    }

    /// Stands for a member's own detached work: no call of a caller who waits.
    static Call& detached_work() {
        static const std::function<void()> none;
        static Call call{none};
        return call;
    }

    std::mutex mutex_;
    std::vector<Member*> idle_;  // a stack: the memory of the last one is warm
    std::size_t threads_ = 0;
    int cores_ = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    std::atomic<int> working_{0};  // callers, and the threads that help them
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

void start_on_pool(std::function<void()> work) {
    of_this_process<ThreadPool>().start(std::move(work));
}

}  // namespace meanvalue
