// Running library code that cannot be interrupted without making a cancel wait for it.
#pragma once

#include <functional>

#include "meanvalue/common/execution.h"

namespace meanvalue {

/// Runs `work` on a thread of its own and waits for it.
///
/// On cancel the wait ends at once and the thread is left to finish by itself; its result is never looked at.
/// Therefore `work` must own all it touches (by shared_ptr) and must not refer to the caller's memory.
/// @throws Cancelled, or whatever `work` throws.
void run_abandonable(const std::function<void()>& work, const Execution& execution);

}  // namespace meanvalue
