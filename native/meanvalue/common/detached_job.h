// Running what a cancel must not wait for: the freeing of gigabytes.
#pragma once

#include <functional>

#include "meanvalue/common/execution.h"

namespace meanvalue {

/// Runs `work` on a thread of its own and waits for it.
///
/// On cancel the wait ends at once and the thread is left to finish by itself; its result is never looked at.
/// Therefore `work` must own all it touches (by shared_ptr) and must not refer to the caller's memory; what it owns
/// is freed on its thread. `work` may itself call this. The next call first waits for all that was left behind, so
/// that cancelling again and again piles nothing up.
/// @throws Cancelled, SolverFailure where the system has no thread to spare, or whatever `work` throws.
void run_detached(const std::function<void()>& work, const Execution& execution);

/// Waits for work that was left behind. To be called before the process ends: libraries must not be taken down under
/// a thread that runs in them.
void wait_for_detached();

}  // namespace meanvalue
