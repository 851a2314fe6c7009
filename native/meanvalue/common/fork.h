// What becomes of the process' own objects when it is forked: the child has none of the threads, and every lock as it
// was at that moment.
#pragma once

#include <atomic>

#ifndef _WIN32
#include <pthread.h>
#endif

namespace meanvalue {

/// The one T of this process. A forked child begins with a new one, and leaves alone what the threads of the other
/// have locked. Never destroyed: threads may outlive static objects.
template <typename T>
T& of_this_process() {
    static std::atomic<T*> instance{nullptr};
    static const bool is_made = [] {
        instance.store(new T);
#ifndef _WIN32  // it has no forks
        pthread_atfork(nullptr, nullptr, [] { instance.store(new T); });
#endif
        return true;
    }();
    static_cast<void>(is_made);
    return *instance.load();
}

}  // namespace meanvalue
