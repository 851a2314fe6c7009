#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/supernodal_pattern.h"

namespace meanvalue {
namespace {

// Tasks are at most this part of all: enough of them for some sixteen threads, few enough to cost nothing.
constexpr std::int64_t kParts = 64;
// Tasks of less are not worth handing over: some ten microseconds.
constexpr std::int64_t kLeastWeight = 30000;

struct Subtrees {
    std::vector<std::int64_t> weight;
    std::vector<Index> first;  // node of the subtree
    std::int64_t total = 0;
};

Subtrees subtrees_of(const std::vector<Index>& parents, const std::vector<std::int64_t>& weights) {
    const auto count = static_cast<Index>(parents.size());
    Subtrees subtrees{weights, std::vector<Index>(count), 0};
    for (Index node = 0; node < count; ++node)
        subtrees.first[node] = node;
    for (Index node = 0; node < count; ++node) {
        const Index parent = parents[node];
        if (parent < 0) {
            subtrees.total += subtrees.weight[node];
            continue;
        }
        subtrees.weight[parent] += subtrees.weight[node];
        subtrees.first[parent] = std::min(subtrees.first[parent], subtrees.first[node]);
    }
    return subtrees;
}

/// The ranges of nodes alone.
std::vector<EliminationTask> ranges_of(const std::vector<Index>& parents, const Subtrees& subtrees) {
    const auto count = static_cast<Index>(parents.size());
    const std::int64_t most = std::max(kLeastWeight, subtrees.total / kParts);
    const auto is_large = [&](Index node) { return node >= 0 && subtrees.weight[node] > most; };
    std::vector<Index> large_children(count, 0);
    for (Index node = 0; node < count; ++node) {
        if (is_large(node) && parents[node] >= 0) ++large_children[parents[node]];
    }
    std::vector<EliminationTask> tasks;
    std::int64_t weight = 0;  // of the last task, where it is of small subtrees
    for (Index node = 0; node < count; ++node) {
        if (is_large(node)) {
            const bool goes_on = !tasks.empty() && tasks.back().end == node && is_large(node - 1) &&
                                 parents[node - 1] == node && large_children[node] == 1;
            if (!goes_on) tasks.push_back({node, node, -1, {}});
            tasks.back().end = node + 1;
        } else if (parents[node] < 0 || is_large(parents[node])) {  // a whole small subtree
            const bool goes_on = !tasks.empty() && !is_large(tasks.back().end - 1) &&
                                 parents[tasks.back().end - 1] == parents[node] &&
                                 weight + subtrees.weight[node] <= most;
            if (!goes_on) {
                tasks.push_back({subtrees.first[node], 0, -1, {}});
                weight = 0;
            }
            tasks.back().end = node + 1;
            weight += subtrees.weight[node];
        }
    }
    return tasks;
}

}  // namespace

std::vector<EliminationTask> cut_into_tasks(const std::vector<Index>& parents,
                                            const std::vector<std::int64_t>& weights) {
    std::vector<EliminationTask> tasks = ranges_of(parents, subtrees_of(parents, weights));
    std::vector<Index> task_of(parents.size());
    const auto count = static_cast<Index>(tasks.size());
    for (Index t = 0; t < count; ++t)
        std::fill(task_of.begin() + tasks[t].begin, task_of.begin() + tasks[t].end, t);
    for (Index t = 0; t < count; ++t) {
        const Index above = parents[tasks[t].end - 1];
        if (above < 0) continue;
        tasks[t].parent = task_of[above];
        tasks[tasks[t].parent].children.push_back(t);
    }
    return tasks;
}

void run_tasks(const std::vector<EliminationTask>& tasks, int threads, const Execution& execution,
               const std::function<void(Index, int)>& up, const std::function<void(Index, int)>& down) {
    struct Job {
        Index task;
        bool is_down;
    };
    // All under the mutex.
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t unfinished = 2 * tasks.size();
    std::vector<Index> unfinished_children;
    std::vector<Job> ready;  // a stack
    ready.reserve(tasks.size());
    unfinished_children.reserve(tasks.size());
    for (std::size_t t = 0; t < tasks.size(); ++t) {
        unfinished_children.push_back(static_cast<Index>(tasks[t].children.size()));
        if (tasks[t].children.empty()) ready.push_back({static_cast<Index>(t), false});
    }
    const auto finish = [&](const Job& job) {
        --unfinished;
        const EliminationTask& task = tasks[job.task];
        if (job.is_down) {
            for (const Index child : task.children)
                ready.push_back({child, true});
        } else if (task.parent < 0) {
            ready.push_back({job.task, true});
        } else if (--unfinished_children[task.parent] == 0) {
            ready.push_back({task.parent, false});
        }
    };
    run_workers(std::min(threads, static_cast<int>(std::max<std::size_t>(tasks.size(), 1))), [&](int worker) {
        std::unique_lock<std::mutex> lock(mutex);
        while (changed.wait(lock, [&] { return unfinished == 0 || !ready.empty(); }), unfinished > 0) {
            const Job job = ready.back();
            ready.pop_back();
            lock.unlock();
            try {
                execution.check();
                (job.is_down ? down : up)(job.task, worker);
            } catch (...) {
                lock.lock();
                unfinished = 0;  // for the others
                changed.notify_all();
                throw;
            }
            lock.lock();
            if (unfinished > 0) finish(job);
            changed.notify_all();
        }
    });
}

}  // namespace meanvalue
