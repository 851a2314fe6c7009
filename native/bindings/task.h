// Work beside the interpreter: on a thread that never touches Python, not even to hand over its result.
//
// A Python thread would do, were it not for Blender: up to Python 3.11 it takes "some thread runs Python" for "this
// thread may use Python", and crashes when another thread has the interpreter while it evaluates drivers or
// operators.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/fork.h"

namespace meanvalue::bindings {

namespace py = pybind11;

/// One piece of work that runs. Its members are called with the interpreter held.
class Task {
  public:
    /// Makes the Python object of a result; called once it is asked for, with the interpreter held.
    using Deliver = std::function<py::object()>;

    /// Starts `work`, which must own all it touches, nothing of Python's among it.
    /// @throws SolverFailure where the system has no thread to spare.
    Task(std::shared_ptr<Execution> execution, std::function<Deliver()> work);

    bool finished() const;

    /// Waits at most so many seconds, without end if there are none, or more than a year. @return finished().
    /// @throws SolverFailure in a forked child, where it was still running before.
    bool wait(std::optional<double> seconds) const;

    /// Waits for the end. @throws what `work` threw.
    py::object result() const;

  private:
    struct State {
        std::shared_ptr<Execution> execution;
        unsigned generation = fork_generation();
        std::mutex mutex;
        std::condition_variable changed;
        std::atomic<bool> is_done{false};  // written last: what comes after may be read then
        std::exception_ptr failure;
        Deliver deliver;
    };

    std::shared_ptr<State> state_;
};

/// Cancels all tasks and waits until they have noticed: before the process ends.
void cancel_tasks();

}  // namespace meanvalue::bindings
