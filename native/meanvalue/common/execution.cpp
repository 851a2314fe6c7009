#include "meanvalue/common/execution.h"

#include "meanvalue/common/errors.h"

namespace meanvalue {

void Execution::check() const {
    if (cancelled()) throw Cancelled();
}

void Execution::begin_stage(const char* name) {
    check();
    stage_.store(name, std::memory_order_relaxed);
    set_progress(0.0);
}

}  // namespace meanvalue
