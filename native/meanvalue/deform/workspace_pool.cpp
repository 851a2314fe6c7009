#include "meanvalue/deform/workspace_pool.h"

#include <algorithm>
#include <utility>

namespace meanvalue {
namespace {

// What is kept idle: memory against the time to take it again, which is that of a solve.
constexpr std::size_t kMostBytes = std::size_t{512} << 20;
constexpr std::size_t kFewest = 2;
constexpr std::size_t kMost = 8;

}  // namespace

std::unique_ptr<Workspace> WorkspacePool::take(const Execution& execution) {
    {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock && !idle_.empty()) {
            std::unique_ptr<Workspace> workspace = std::move(idle_.back());
            idle_.pop_back();
            return workspace;
        }
        if (lock) idle_.reserve(kMost);  // so that giving back takes no memory
    }
    return decoder_.make_workspace(execution);
}

void WorkspacePool::give_back(std::unique_ptr<Workspace> workspace) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    const std::size_t bytes = std::max<std::size_t>(decoder_.memory().workspace, 1);
    const std::size_t most = std::clamp(kMostBytes / bytes, kFewest, kMost);
    if (lock && idle_.size() < std::min(most, idle_.capacity())) idle_.push_back(std::move(workspace));
}

}  // namespace meanvalue
