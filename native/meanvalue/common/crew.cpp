#include "meanvalue/common/crew.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#include "meanvalue/common/fork.h"

namespace meanvalue {
namespace {

// Looks at the clock-free counter so often before sleeping, some 50 microseconds: parallel calls follow close upon
// another within an iteration, and waking a sleeping thread takes as long.
constexpr int kPatience = 4000;

void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

class Crew {
  public:
    bool run(int workers, const std::function<void(int)>& work) {
        if (is_taken_.test_and_set(std::memory_order_acquire)) return false;
        const bool is_complete = recruit(workers - 1);
        if (is_complete) {
            work_ = &work;
            wanted_ = workers - 1;
            working_.store(members_, std::memory_order_relaxed);
            {
                const std::lock_guard<std::mutex> lock(mutex_);
                round_.fetch_add(1, std::memory_order_release);
            }
            wake_.notify_all();
            work(0);
            for (int turn = 0; working_.load(std::memory_order_acquire) > 0; ++turn) {
                if (turn < kPatience) {
                    relax();
                } else {
                    std::this_thread::yield();
                }
            }
        }
        is_taken_.clear(std::memory_order_release);
        return is_complete;
    }

  private:
    bool recruit(int count) {
        try {
            for (; members_ < count; ++members_) {
                // Detached: they sleep until the process ends, and a crew is never destroyed.
                std::thread(&Crew::serve, this, members_ + 1, round_.load(std::memory_order_relaxed)).detach();
            }
        } catch (const std::system_error&) {
            return false;
        }
        return true;
    }

    void serve(int number, unsigned last_round) {
        for (;;) {
            for (int turn = 0; turn < kPatience && round_.load(std::memory_order_acquire) == last_round; ++turn)
                relax();
            if (round_.load(std::memory_order_acquire) == last_round) {
                std::unique_lock<std::mutex> lock(mutex_);
                wake_.wait(lock, [&] { return round_.load(std::memory_order_relaxed) != last_round; });
            }
            last_round = round_.load(std::memory_order_acquire);
            if (number <= wanted_) (*work_)(number);
            working_.fetch_sub(1, std::memory_order_acq_rel);
        }
    }

    std::atomic_flag is_taken_ = ATOMIC_FLAG_INIT;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::atomic<unsigned> round_{0};
    std::atomic<int> working_{0};
    const std::function<void(int)>* work_ = nullptr;
    int wanted_ = 0;
    int members_ = 0;
};

}  // namespace

bool run_on_crew(int workers, const std::function<void(int)>& work) {
    return of_this_process<Crew>().run(workers, work);
}

}  // namespace meanvalue
