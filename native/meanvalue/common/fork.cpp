#include "meanvalue/common/fork.h"

#ifndef _WIN32
#include <pthread.h>
#endif

namespace meanvalue {

void call_after_fork(void (*handler)()) {
#ifndef _WIN32
    pthread_atfork(nullptr, nullptr, handler);
#else
    static_cast<void>(handler);
#endif
}

unsigned fork_generation() {
    static std::atomic<unsigned> generation{0};
    static const bool is_counted = [] {
        call_after_fork([] { ++generation; });
        return true;
    }();
    static_cast<void>(is_counted);
    return generation.load();
}

}  // namespace meanvalue
