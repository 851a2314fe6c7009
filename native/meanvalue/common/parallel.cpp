#include "meanvalue/common/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/thread_pool.h"

namespace meanvalue {
namespace {

// As many threads may be asked for where there are fewer cores: more than one shows on any computer that results do
// not depend on it.
constexpr int kMostWithoutCores = 8;

}  // namespace

int thread_count(int requested) {
    if (requested < 0) {
        throw InvalidInput(message("threads is ", requested, "; give 0 for all cores or a positive number"));
    }
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    return requested > 0 ? std::min(requested, std::max(kMostWithoutCores, cores)) : cores;
}

void run_workers(int workers, const std::function<void(int)>& body) {
    if (workers == 1) return body(0);
    std::vector<std::exception_ptr> failures(workers);
    const auto work = [&](int worker) {
        try {
            body(worker);
        } catch (...) {
            failures[worker] = std::current_exception();
        }
    };
    run_on_pool(workers, work);
    for (const std::exception_ptr& failure : failures) {
        if (failure) std::rethrow_exception(failure);
    }
}

void parallel_for(Index count, int threads, const Execution& execution,
                  const std::function<void(Index, Index)>& body) {
    parallel_pieces(count, threads, execution, [&](Index, Index begin, Index end) { body(begin, end); });
}

Index piece_count(Index count) {
    return (count + kPiece - 1) / kPiece;
}

void parallel_pieces(Index count, int threads, const Execution& execution,
                     const std::function<void(Index, Index, Index)>& body) {
    const int workers = std::min<int>(threads, count / kPiece);  // else one might wake up for a single row
    parallel_items(piece_count(count), workers, execution, [&](int, std::size_t item) {
        const auto piece = static_cast<Index>(item);
        body(piece, piece * kPiece, std::min(count, (piece + 1) * kPiece));
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

}  // namespace meanvalue
