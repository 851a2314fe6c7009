#include "meanvalue/common/parallel.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "meanvalue/common/errors.h"

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
    std::vector<std::thread> others;
    others.reserve(workers - 1);
    int started = 1;
    try {
        for (; started < workers; ++started)
            others.emplace_back(work, started);
    } catch (const std::system_error&) {
        // The system has no thread to spare: what is left over is done here instead.
    }
    work(0);
    for (int worker = started; worker < workers; ++worker)
        work(worker);
    for (std::thread& other : others)
        other.join();
    for (const std::exception_ptr& failure : failures) {
        if (failure) std::rethrow_exception(failure);
    }
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

}  // namespace meanvalue
