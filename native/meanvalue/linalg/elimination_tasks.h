// A tree of columns cut into tasks that can be done at the same time, and what runs them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Consecutive nodes of a forest in postorder: whole subtrees side by side, or a piece of a path.
/// Tasks are in postorder, too: a parent comes after its children.
struct EliminationTask {
    Index begin;  // nodes
    Index end;
    Index parent;                 // the task of the node above, or -1
    std::vector<Index> children;  // ascending
};

/// Cuts a forest into tasks, the same for any number of threads. A small forest is one task.
/// @param parents of each node, which comes before its parent (postorder); -1 for a root.
/// @param weights the work at each node.
std::vector<EliminationTask> cut_into_tasks(const std::vector<Index>& parents,
                                            const std::vector<std::int64_t>& weights);

/// Calls up(task, worker) for every task after its children, and down(task, worker) after its parent and after up()
/// of all above it, with as many calls at the same time as there are threads. Which worker calls, and in what order
/// the calls come, must not matter to the result.
/// @param threads as given by thread_count(); `worker` is less. @throws Cancelled, or what the functions throw.
void run_tasks(const std::vector<EliminationTask>& tasks, int threads, const Execution& execution,
               const std::function<void(Index task, int worker)>& up,
               const std::function<void(Index task, int worker)>& down);

}  // namespace meanvalue
