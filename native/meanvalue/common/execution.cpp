#include "meanvalue/common/execution.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {

void Execution::check() const {
    if (checks_left_.load(std::memory_order_relaxed) > 0 &&
        checks_left_.fetch_sub(1, std::memory_order_relaxed) == 1) {
        cancelled_.store(true, std::memory_order_relaxed);
    }
    if (whole_ != nullptr) whole_->check();
    if (cancelled()) throw Cancelled();
}

void Execution::begin_stage(const char* name) {
    check();
    stage_.store(name, std::memory_order_relaxed);
    set_progress(0.0);
}

}  // namespace meanvalue
