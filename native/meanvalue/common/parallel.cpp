#include "meanvalue/common/parallel.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/thread_pool.h"

namespace meanvalue {
namespace {

// Long enough to hide the cost of a call, short enough for cancellation to be seen within milliseconds.
constexpr Index kPiece = 2048;

void run_pieces(Index begin, Index end, const Execution& execution, const std::function<void(Index, Index)>& body) {
    for (Index first = begin; first < end; first += std::min(kPiece, end - first)) {
        execution.check();
        body(first, first + std::min(kPiece, end - first));
    }
}

// A range below this is quicker done by one thread than shared out.
constexpr Index kShared = 512;

/// Lets no thread of a team pass before all have come.
class Barrier {
  public:
    void wait(int members) {
        const int round = round_.load(std::memory_order_acquire);
        if (waiting_.fetch_add(1, std::memory_order_acq_rel) + 1 == members) {
            waiting_.store(0, std::memory_order_relaxed);
            round_.store(round + 1, std::memory_order_release);
            return;
        }
        // Ranges take microseconds, less than waking a sleeping thread; where cores are short, others get this one.
        for (int turn = 0; round_.load(std::memory_order_acquire) == round; ++turn) {
            if (turn >= kPatience) std::this_thread::yield();
        }
    }

  private:
    static constexpr int kPatience = 1000;
    std::atomic<int> waiting_{0};
    std::atomic<int> round_{0};
};

void rethrow_first(const std::vector<std::exception_ptr>& failures) {
    for (const std::exception_ptr& failure : failures) {
        if (failure) std::rethrow_exception(failure);
    }
}

}  // namespace

int thread_count(int requested) {
    if (requested < 0) {
        throw InvalidInput(message("threads is ", requested, "; give 0 for all cores or a positive number"));
    }
    if (requested > 0) return requested;
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void run_workers(int workers, const std::function<void(int)>& body) {
    std::vector<std::exception_ptr> failures(workers);
    const auto work = [&](int worker) {
        try {
            body(worker);
        } catch (...) {
            failures[worker] = std::current_exception();
        }
    };
    run_on_pool(workers, work);
    rethrow_first(failures);
}

void parallel_for(Index count, int threads, const Execution& execution,
                  const std::function<void(Index, Index)>& body) {
    const int workers = std::min<int>(threads, (count + kPiece - 1) / kPiece);
    if (workers <= 1) {
        run_pieces(0, count, execution, body);
        return;
    }
    const auto share = [&](int k) { return static_cast<Index>(std::int64_t{count} * k / workers); };
    run_workers(workers, [&](int worker) { run_pieces(share(worker), share(worker + 1), execution, body); });
}

Index piece_count(Index count) {
    return (count + kPiece - 1) / kPiece;
}

void parallel_pieces(Index count, int threads, const Execution& execution,
                     const std::function<void(Index, Index, Index)>& body) {
    const Index pieces = piece_count(count);
    const int workers = std::max(1, std::min<int>(threads, pieces));
    run_workers(workers, [&](int worker) {
        const auto share = [&](int k) { return static_cast<Index>(std::int64_t{pieces} * k / workers); };
        for (Index piece = share(worker); piece < share(worker + 1); ++piece) {
            execution.check();
            body(piece, piece * kPiece, std::min(count, (piece + 1) * kPiece));
        }
    });
}

void parallel_items(std::size_t count, int threads, const Execution& execution,
                    const std::function<void(int, std::size_t)>& body) {
    const auto most = static_cast<std::size_t>(std::max(1, threads));
    std::atomic<std::size_t> next{0};
    run_workers(static_cast<int>(std::min(most, std::max<std::size_t>(count, 1))), [&](int worker) {
        try {
            for (std::size_t item = next++; item < count; item = next++) {
                execution.check();
                body(worker, item);
            }
        } catch (...) {
            next = count;
            throw;
        }
    });
}

void parallel_in_turn(const std::vector<Index>& bounds, int threads, const Execution& execution,
                      const std::function<void(Index, Index)>& body) {
    if (bounds.empty()) return;
    const int workers = std::min<int>(threads, (bounds.back() - bounds.front() + kPiece - 1) / kPiece);
    if (workers <= 1) {
        for (std::size_t k = 0; k + 1 < bounds.size(); ++k)
            run_pieces(bounds[k], bounds[k + 1], execution, body);
        return;
    }
    std::vector<std::exception_ptr> failures(workers);
    std::atomic<bool> failed{false};
    Barrier barrier;
    run_team_on_pool(workers, [&](int member, int members) {
        for (std::size_t k = 0; k + 1 < bounds.size(); ++k) {
            const Index begin = bounds[k];
            const Index count = bounds[k + 1] - begin;
            const bool shared = count >= kShared;
            const auto share = [&](int number) {
                return begin + static_cast<Index>(std::int64_t{count} * number / members);
            };
            // Whoever fails still comes to every barrier, or the others would wait for ever.
            try {
                if (!failed && (shared || member == 0)) {
                    run_pieces(shared ? share(member) : begin, shared ? share(member + 1) : bounds[k + 1], execution,
                               body);
                }
            } catch (...) {
                failures[member] = std::current_exception();
                failed = true;
            }
            // The first thread goes through short ranges alone, and the others meet it at the next that is shared.
            const bool next_shared = k + 2 < bounds.size() && bounds[k + 2] - bounds[k + 1] >= kShared;
            if (shared || next_shared) barrier.wait(members);
        }
    });
    rethrow_first(failures);
}

}  // namespace meanvalue
