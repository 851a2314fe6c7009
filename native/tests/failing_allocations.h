// Memory that runs out at a chosen place: operator new of the test program fails when it is told to.
#pragma once

#include <cstdint>

namespace meanvalue::tests {

/// As long as this lives, allocation number `count` from now on, counted from 0, throws std::bad_alloc, on whichever
/// thread; the others do not. Eigen's matrices are not among them: they come from malloc.
class FailingAllocation {
  public:
    explicit FailingAllocation(std::int64_t count);
    FailingAllocation(const FailingAllocation&) = delete;
    FailingAllocation& operator=(const FailingAllocation&) = delete;
    ~FailingAllocation();

    /// Whether it has come to that allocation.
    bool has_failed() const;
    /// How many more there may be before it does.
    std::int64_t remaining() const;
    /// False under sanitizers, which have an operator new of their own: nothing fails then.
    static bool is_there();
};

}  // namespace meanvalue::tests
