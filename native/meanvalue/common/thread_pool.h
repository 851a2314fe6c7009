// The threads of the core, all of them: for loops, and for work that nobody waits for.
#pragma once

#include <functional>

namespace meanvalue {

/// Calls work(0), work(1), ... work(workers - 1), each once, on this thread and as many others as there is work and
/// room for; returns when all have returned. Calls may come one after another on the same thread: none may wait for
/// another to begin. @pre work does not throw.
///
/// Threads stay, and are shared by all callers of the process: none is sent to help where as many work on calls as
/// there are cores, or as the largest number of workers asked for, whichever is more. A thread that the system
/// refuses is done without. A forked child begins with none.
void run_on_pool(int workers, const std::function<void(int worker)>& work);

/// Runs `work` on a thread of its own, whatever else runs, and waits for nothing. @pre work does not throw.
/// @throws SolverFailure where the system has no thread to spare.
void start_thread(std::function<void()> work);

/// Has what the C++ runtime and the pool keep for this thread made now. The loader makes it at its first use, which
/// is where the first exception is thrown, and ends the process if it has no memory then. Threads of the pool begin
/// with it. @pre no call of this thread runs.
void prepare_thread();

}  // namespace meanvalue
