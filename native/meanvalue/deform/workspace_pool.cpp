#include "meanvalue/deform/workspace_pool.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "meanvalue/common/fork.h"

namespace meanvalue {
namespace {

constexpr std::size_t kMostBytes = std::size_t{512} << 20;
constexpr std::size_t kFewest = 2;
constexpr std::size_t kMost = 8;
// How often a solve that waits looks at its cancel flag.
constexpr std::chrono::milliseconds kPollInterval{5};

std::size_t most_idle(const Workspace& workspace) {
    return std::clamp(kMostBytes / std::max<std::size_t>(workspace.bytes(), 1), kFewest, kMost);
}

}  // namespace

WorkspacePool::WorkspacePool(const Decoder& decoder) : decoder_(decoder), state_(nullptr) {}

WorkspacePool::~WorkspacePool() {
    State* const last = state_.load();
    // Another process' may be locked for ever.
    if (last != nullptr && last->generation == fork_generation()) delete last;
}

WorkspacePool::State& WorkspacePool::state() {
    State* known = state_.load(std::memory_order_acquire);
    while (known == nullptr || known->generation != fork_generation()) {
        auto fresh = std::make_unique<State>();
        fresh->generation = fork_generation();
        if (state_.compare_exchange_strong(known, fresh.get())) return *fresh.release();
    }
    return *known;
}

std::unique_ptr<Workspace> WorkspacePool::take(const Positions* previous, const Execution& execution) {
    State& state = this->state();
    std::unique_lock<std::mutex> lock(state.mutex);
    std::vector<std::unique_ptr<Workspace>>& idle = state.idle;
    const auto is_cancelled = [](const Execution* running) { return running->cancelled(); };
    auto found = idle.end();
    while (previous != nullptr) {
        found = std::find_if(idle.begin(), idle.end(),
                             [&](const auto& workspace) { return workspace->goes_on_from(*previous); });
        if (found != idle.end()) break;
        if (std::none_of(state.running.begin(), state.running.end(), is_cancelled)) break;
        state.returned.wait_for(lock, kPollInterval);
        execution.check();
    }
    if (found == idle.end()) {
        found =
            std::find_if(idle.begin(), idle.end(), [](const auto& workspace) { return !workspace->has_answer(); });
    }
    if (found == idle.end() && !idle.empty() && idle.size() >= most_idle(*idle.front())) found = idle.begin();
    std::unique_ptr<Workspace> workspace;
    if (found != idle.end()) {
        workspace = std::move(*found);
        idle.erase(found);
    }
    idle.reserve(idle.size() + state.running.size() + 1);  // so that each may be given back
    state.running.push_back(&execution);
    return workspace;
}

void WorkspacePool::give_back(std::unique_ptr<Workspace> workspace, const Execution& execution) {
    State& state = this->state();
    {
        const std::lock_guard<std::mutex> lock(state.mutex);
        const auto running = std::find(state.running.begin(), state.running.end(), &execution);
        if (running != state.running.end()) state.running.erase(running);
        if (workspace) {
            const std::size_t most = most_idle(*workspace);
            state.idle.push_back(std::move(workspace));
            if (state.idle.size() > most) {
                workspace = std::move(state.idle.front());  // freed without the lock
                state.idle.erase(state.idle.begin());
            }
        }
    }
    state.returned.notify_all();
}

WorkspacePool::Loan::Loan(WorkspacePool& pool, const Positions* previous, const Execution& execution)
    : pool_(pool), execution_(execution), workspace_(pool.take(previous, execution)) {
    if (workspace_) return;
    try {
        workspace_ = pool.decoder_.make_workspace(execution);
    } catch (...) {
        pool.give_back(nullptr, execution);
        throw;
    }
}

WorkspacePool::Loan::~Loan() {
    pool_.give_back(std::move(workspace_), execution_);
}

std::size_t WorkspacePool::bytes_of_each(const Execution& execution) {
    return Loan(*this, nullptr, execution).workspace().bytes();
}

}  // namespace meanvalue
