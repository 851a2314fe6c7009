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

}  // namespace meanvalue
