#include "tests/failing_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MEANVALUE_OWN_NEW 0
#else
#define MEANVALUE_OWN_NEW 1
#endif

namespace meanvalue::tests {
namespace {

constexpr std::int64_t kNone = INT64_MIN;
std::atomic<std::int64_t> left{kNone};  // below 0: it has failed

}  // namespace

FailingAllocation::FailingAllocation(std::int64_t count) {
    left = count;
}

FailingAllocation::~FailingAllocation() {
    left = kNone;
}

bool FailingAllocation::has_failed() const {
    return left.load() < 0;
}

std::int64_t FailingAllocation::remaining() const {
    return left.load();
}

bool FailingAllocation::is_there() {
    return MEANVALUE_OWN_NEW != 0;
}

}  // namespace meanvalue::tests

#if MEANVALUE_OWN_NEW
void* operator new(std::size_t size) {
    using meanvalue::tests::kNone;
    using meanvalue::tests::left;
    if (left.load(std::memory_order_relaxed) != kNone && left.fetch_sub(1) == 0) throw std::bad_alloc();
    void* const memory = std::malloc(size == 0 ? 1 : size);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void operator delete(void* memory) noexcept {
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
#endif
