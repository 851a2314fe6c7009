// Wall-clock seconds by stage, for reports.
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace meanvalue {

/// Seconds spent in each named stage.
using Timings = std::map<std::string, double>;

/// Adds the time from its construction to its destruction to one stage.
class StageTimer {
  public:
    StageTimer(Timings& timings, std::string stage)
        : timings_(timings), stage_(std::move(stage)), start_(Clock::now()) {}
    ~StageTimer() { timings_[stage_] += std::chrono::duration<double>(Clock::now() - start_).count(); }
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;

  private:
    using Clock = std::chrono::steady_clock;
    Timings& timings_;
    std::string stage_;
    Clock::time_point start_;
};

}  // namespace meanvalue
