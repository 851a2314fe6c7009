// Wall-clock seconds by stage, for reports.
#pragma once

#include <chrono>
#include <string>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// Adds the time from its construction to its destruction to one stage. @pre the stage stays in the map so long.
class StageTimer {
  public:
    /// Makes the entry here: at its end, which may be that of an error, nothing is to be allocated.
    StageTimer(Timings& timings, const std::string& stage) : seconds_(timings[stage]), start_(Clock::now()) {}
    ~StageTimer() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;

  private:
    using Clock = std::chrono::steady_clock;
    double& seconds_;
    Clock::time_point start_;
};

}  // namespace meanvalue
