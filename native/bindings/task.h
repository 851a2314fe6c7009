// Work beside the interpreter: on a thread that never touches Python, not even to hand over its result.
//
// A Python thread would do, were it not for Blender: up to Python 3.11 it takes "some thread runs Python" for "this
// thread may use Python", and crashes when another thread has the interpreter while it evaluates drivers or
// operators.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "meanvalue/common/execution.h"

namespace meanvalue::bindings {

namespace py = pybind11;

/// One piece of work that runs. Its members are called with the interpreter held.
class Task {
  public:
    /// Makes the Python object of a result; called once it is asked for, with the interpreter held.
    using Deliver = std::function<py::object()>;

    /// Starts `work`, which must own all it touches, nothing of Python's among it.
    /// @param early makes what there is to use before the result, None where there is nothing.
    /// @throws SolverFailure where the system has no thread to spare.
    Task(std::shared_ptr<Execution> execution, std::function<Deliver()> work, Deliver early = {});

    bool finished() const;

    /// Waits at most so many seconds, without end if there are none, or more than a year. @return finished().
    /// @throws SolverFailure in a forked child, where it was still running before; what a handler of Python's raises
    /// for a signal, as for Ctrl-C.
    bool wait(std::optional<double> seconds) const;

    /// Waits for the end. Where the execution is cancelled this waits no longer: what runs then ends by itself, which
    /// may take long, as for gigabytes to be freed. @throws what `work` threw, Cancelled; as wait(), which cancels
    /// it.
    py::object result() const;

    /// Waits for the end, whatever signals there are.
    void end() const;

    py::object early() const { return early_ ? early_() : py::none(); }

  private:
    /// Another in a forked child.
    static const void* this_process();
    bool end_by(std::chrono::steady_clock::time_point time) const;

    struct State {
        std::shared_ptr<Execution> execution;
        const void* process = this_process();
        std::mutex mutex;
        std::condition_variable changed;
        std::atomic<bool> is_done{false};  // written last: what comes after may be read then
        std::exception_ptr failure;
        Deliver deliver;
    };

    std::shared_ptr<State> state_;
    Deliver early_;
};

/// Cancels all tasks and waits until they have ended: before the process ends.
void cancel_tasks();

/// Waits for tasks that were cancelled and have not ended, so that cancelling again and again piles nothing up.
/// For work that takes much memory. @throws Cancelled by `execution`.
void wait_for_cancelled_tasks(const Execution& execution);

/// The call that waits for what `start` begins.
template <typename... Arguments>
auto waiting_for(Task (*start)(Arguments...)) {
    return [start](Arguments... arguments) { return start(std::forward<Arguments>(arguments)...).result(); };
}

/// What `work` returns, which runs beside the interpreter: cancelled, and waited for, where a signal is to be
/// handled. It may look at what the caller has, but at nothing of Python's.
template <typename Work>
auto beside(const std::shared_ptr<Execution>& execution, const Work& work) {
    std::optional<decltype(work())> result;
    const Task task(execution, [&]() -> Task::Deliver {
        result.emplace(work());
        return [] { return py::none(); };
    });
    try {
        task.result();
    } catch (...) {
        task.end();
        throw;
    }
    return std::move(*result);
}

/// Binds `start` twice: as `name`, which waits for its result, and as start_NAME, which returns the Task.
template <typename Owner, typename Start, typename... Arguments>
void def_with_start(Owner& owner, const std::string& name, Start start, const std::string& text,
                    const Arguments&... arguments) {
    owner.def(name.c_str(), waiting_for(start), arguments..., text.c_str());
    owner.def(("start_" + name).c_str(), start, arguments...,
              ("As " + name +
               "(), beside the interpreter. Returns a Task whose result is the same.\n\n"
               "Arrays are copied first. Raises InvalidInput for arrays of another form.")
                  .c_str());
}

}  // namespace meanvalue::bindings
