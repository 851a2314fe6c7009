// Cancel and progress of one long operation, shared between the thread that works and those that watch.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace meanvalue {

/// Passed down to everything that may take long. Every member may be called from any thread.
/// One object serves one operation: once cancelled, it stays cancelled.
class Execution {
  public:
    Execution() = default;
    /// For one part of an operation: cancelled with it, and with progress of its own. @pre `whole` outlives it.
    explicit Execution(const Execution* whole) : whole_(whole) {}
    Execution(const Execution&) = delete;
    Execution& operator=(const Execution&) = delete;

    /// Asks the operation to stop; it throws Cancelled within about 100 ms.
    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    bool cancelled() const {
        return cancelled_.load(std::memory_order_relaxed) || (whole_ != nullptr && whole_->cancelled());
    }

    /// Cancels itself at the call of check() with this number from now on, counted from 1: tests cancel with it
    /// anywhere in an operation.
    void cancel_at_check(std::int64_t checks) { checks_left_.store(checks, std::memory_order_relaxed); }

    /// @throws Cancelled after cancel(); called inside every long loop.
    void check() const;

    /// For serial loops: checks in every 2048th round, which costs nothing.
    /// @throws Cancelled.
    void check_every(std::size_t round) const {
        if (round % 2048 == 0) check();
    }

    /// Names what is being done. @param name a string literal: it is kept, not copied.
    void begin_stage(const char* name);
    const char* stage() const { return stage_.load(std::memory_order_relaxed); }

    /// How far the current stage is, from 0 to 1.
    void set_progress(double fraction) { progress_.store(fraction, std::memory_order_relaxed); }
    double progress() const { return progress_.load(std::memory_order_relaxed); }

  private:
    const Execution* whole_ = nullptr;
    mutable std::atomic<bool> cancelled_{false};
    mutable std::atomic<std::int64_t> checks_left_{0};  // 0: it does not cancel itself
    std::atomic<const char*> stage_{""};
    std::atomic<double> progress_{0.0};
};

/// For serial loops whose rounds differ much in length: checks by the work that was done, not by rounds.
class WorkMeter {
  public:
    explicit WorkMeter(const Execution& execution) : execution_(execution) {}

    /// @param steps of some nanoseconds. @throws Cancelled.
    void add(std::size_t steps) {
        steps_ += steps;
        if (steps_ < kStepsPerCheck) return;
        steps_ = 0;
        execution_.check();
    }

  private:
    static constexpr std::size_t kStepsPerCheck = 1 << 18;  // about a millisecond
    const Execution& execution_;
    std::size_t steps_ = 0;
};

}  // namespace meanvalue
