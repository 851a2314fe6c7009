// Threads that stay between parallel calls: starting one costs as much as a small level's whole share of work.
#pragma once

#include <functional>

namespace meanvalue {

/// Calls work(0) here and work(1) to work(workers - 1) on threads that are kept for the next call, all at once, and
/// waits for them. @return false, and then nothing was called, where the crew works for somebody else (another
/// thread, or the caller itself one call further up) or the system has no threads to spare. @pre work does not throw.
bool run_on_crew(int workers, const std::function<void(int)>& work);

}  // namespace meanvalue
