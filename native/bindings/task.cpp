#include "bindings/task.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "bindings/bind.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/fork.h"
#include "meanvalue/common/thread_pool.h"

namespace meanvalue::bindings {
namespace {

// Clocks count nanoseconds in 64 bits.
constexpr double kLongestWaitSeconds = 3e7;
// How often what waits looks at its cancel flag, and whether Python has a signal to handle, as of Ctrl-C.
constexpr std::chrono::milliseconds kPollInterval{10};

/// What runs, for cancel_tasks().
struct Running {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::shared_ptr<Execution>> executions;

    void add(const std::shared_ptr<Execution>& execution) {
        const std::lock_guard<std::mutex> lock(mutex);
        executions.push_back(execution);
    }

    void remove(const std::shared_ptr<Execution>& execution) {
        const std::lock_guard<std::mutex> lock(mutex);
        executions.erase(std::find(executions.begin(), executions.end(), execution));
        changed.notify_all();
    }
};

Running& running() {
    return of_this_process<Running>();
}

}  // namespace

Task::Task(std::shared_ptr<Execution> execution, std::function<Deliver()> work, Deliver early)
    : state_(std::make_shared<State>()), early_(std::move(early)) {
    state_->execution = std::move(execution);
    running().add(state_->execution);
    try {
        start_thread([state = state_, work = std::move(work)]() mutable {
            Deliver deliver;
            std::exception_ptr failure;
            try {
                deliver = work();
            } catch (...) {
                failure = std::current_exception();
            }
            work = nullptr;  // what it owns is freed here
            {
                const std::lock_guard<std::mutex> lock(state->mutex);
                state->deliver = std::move(deliver);
                state->failure = std::move(failure);
                state->is_done = true;
                state->changed.notify_all();
            }
            const auto execution = state->execution;
            state = nullptr;
            running().remove(execution);
        });
    } catch (...) {
        running().remove(state_->execution);
        throw;
    }
}

const void* Task::this_process() {
    return &running();
}

bool Task::finished() const {
    return state_->is_done;
}

bool Task::wait(std::optional<double> seconds) const {
    const auto state = state_;
    if (!state->is_done && state->process != this_process()) {
        throw ::meanvalue::SolverFailure(
            "the task was begun before this process was forked, and runs on in the other one; start it again here");
    }
    using Clock = std::chrono::steady_clock;
    const std::chrono::duration<double> longest(seconds && *seconds < kLongestWaitSeconds ? std::max(0.0, *seconds)
                                                                                          : kLongestWaitSeconds);
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(longest);
    while (!end_by(std::min(until, Clock::now() + kPollInterval))) {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (Clock::now() >= until) return false;
    }
    return true;
}

bool Task::end_by(std::chrono::steady_clock::time_point time) const {
    const py::gil_scoped_release released;
    std::unique_lock<std::mutex> lock(state_->mutex);
    return state_->changed.wait_until(lock, time, [&] { return state_->is_done.load(); });
}

void Task::end() const {
    while (!end_by(std::chrono::steady_clock::now() + kPollInterval)) {
    }
}

py::object Task::result() const {
    const std::chrono::duration<double> interval = kPollInterval;
    try {
        while (!wait(interval.count()))
            state_->execution->check();
    } catch (const py::error_already_set&) {
        state_->execution->cancel();
        throw;
    }
    if (state_->failure) std::rethrow_exception(state_->failure);
    return state_->deliver();
}

void cancel_tasks() {
    std::unique_lock<std::mutex> lock(running().mutex);
    while (!running().executions.empty()) {  // of others' threads, more may come
        for (const auto& execution : running().executions)
            execution->cancel();
        running().changed.wait(lock);
    }
}

void wait_for_cancelled_tasks(const Execution& execution) {
    const auto is_cancelled = [](const auto& each) { return each->cancelled(); };
    std::unique_lock<std::mutex> lock(running().mutex);
    std::vector<std::shared_ptr<Execution>>& executions = running().executions;
    while (execution.check(), std::any_of(executions.begin(), executions.end(), is_cancelled))
        running().changed.wait_for(lock, kPollInterval);
}

void bind_task(py::module_& module) {
    py::class_<Task>(
        module, "Task", py::module_local(),
        "Work that runs beside the interpreter, on a thread that never touches it.\n\n"
        "Given by start_bind() and Deformer.start_solve(). Dropping it does not stop the work: cancel the\n"
        "Execution that it was given.")
        .def_property_readonly("finished", &Task::finished, "bool: result() would not wait.")
        .def_property_readonly(
            "early", &Task::early,
            "What can be used before the result is there, or None. Of start_bind(early=True) and\n"
            "start_rebind(early=True): a Deformer, once the coarsest level of a large mesh is bound, and until all\n"
            "is. It solves by that level alone and carries the rest along: anchors are at their targets, the shape "
            "is\n"
            "5 to 35 % of its way off. It has no drafts.")
        .def("wait", &Task::wait, py::arg("seconds") = py::none(),
             "Wait at most so many seconds, None: as long as it takes. Returns whether it is finished.")
        .def("result", &Task::result,
             "What the work gives, the same object at every call; waits for it.\n\n"
             "Raises InvalidInput, SolverFailure, Cancelled, as the call that does the same at once; SolverFailure\n"
             "in a forked process, where it was still running before.");
}

}  // namespace meanvalue::bindings
