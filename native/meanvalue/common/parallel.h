// Loops split over threads, with the same result for any number of them.
#pragma once

#include <cstddef>
#include <functional>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// The number of threads that `requested` stands for: itself, at most every core, or 8; every core where it is 0.
/// @throws InvalidInput where it is negative.
int thread_count(int requested);

/// Rows that a thread works on in one go: enough to hide the cost of a call and to share what they have in common,
/// few enough to stay in its cache, and for a cancel to be seen within milliseconds. Fewer are quicker done by the
/// thread that would hand them over.
constexpr Index kPiece = 1024;

/// Calls body(begin, end) on consecutive pieces that together cover [0, count).
///
/// Results are the same for any number of threads as long as each call writes only what belongs to its own
/// piece. @param threads as given by thread_count(). @throws as parallel_items().
void parallel_for(Index count, int threads, const Execution& execution,
                  const std::function<void(Index begin, Index end)>& body);

/// For sums: the same with pieces that are always the same ones, numbered from 0 to piece_count(count). A sum over
/// pieces of sums over each, in order, has the same bits for any number of threads.
void parallel_pieces(Index count, int threads, const Execution& execution,
                     const std::function<void(Index piece, Index begin, Index end)>& body);
Index piece_count(Index count);

/// Calls body(worker) once for each worker in [0, workers), all at the same time where the system has the threads,
/// else some after others: no call may wait for another to begin. Returns when all have; then throws the first
/// exception (in order of workers) again.
void run_workers(int workers, const std::function<void(int worker)>& body);

/// Calls body(worker, item) once for each item in [0, count), on up to `threads` threads that each take the next one
/// when they are done with theirs: for items that take long, some longer than others. `worker` is below
/// min(threads, max(count, 1)), and no other call has it meanwhile. Checks for cancellation between items. After an
/// exception no item is taken any more; it is thrown again, as by run_workers(), once those that had begun are done.
void parallel_items(std::size_t count, int threads, const Execution& execution,
                    const std::function<void(int worker, std::size_t item)>& body);

}  // namespace meanvalue
