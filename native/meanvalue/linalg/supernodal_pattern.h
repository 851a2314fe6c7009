// Where a Cholesky factor has entries: supernodes, found before any value is known.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/graph.h"

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

/// The columns of a factor in supernodes, which are consecutive columns with the same rows. Supernodes are in a
/// postorder of the elimination tree: each comes directly after its descendants.
struct SupernodalPattern {
    /// Columns of a supernode at most; wider ones are a chain of several. A block of rows of so many columns fits the
    /// processor's first cache.
    static constexpr Index kMostColumns = 192;

    std::vector<Index> order;                   // the row of the matrix that is row k of the factor
    std::vector<Index> first_column = {0};      // count() + 1
    std::vector<std::int64_t> first_row = {0};  // count() + 1, in rows
    std::vector<Index> rows;                    // ascending for each supernode, its own columns first
    std::vector<Index> parents;                 // the supernode with the first row below, or -1

    Index size() const { return static_cast<Index>(order.size()); }
    Index count() const { return static_cast<Index>(first_column.size()) - 1; }
    Index width(Index supernode) const { return first_column[supernode + 1] - first_column[supernode]; }
    Index row_count(Index supernode) const {
        return static_cast<Index>(first_row[supernode + 1] - first_row[supernode]);
    }
    const Index* rows_of(Index supernode) const { return rows.data() + first_row[supernode]; }
    /// Numbers of a supernode's columns: a rectangle, of which the upper triangle is not used.
    std::int64_t panel_size(Index supernode) const { return std::int64_t{width(supernode)} * row_count(supernode); }
    /// Multiplications and additions that its elimination takes.
    std::int64_t work(Index supernode) const;
};

/// Order, elimination tree and supernodes of a symmetric matrix.
/// @param lower its lower triangle; entries above the diagonal are ignored, and those on it need not be there.
/// @param threads as given by thread_count(); the result is the same for any.
/// @param order columns in the order of their elimination, which the result's comes near to; empty: nested
/// dissection. @throws Cancelled.
SupernodalPattern find_supernodes(const SparseMatrix& lower, int threads, const Execution& execution,
                                  const std::vector<Index>& order = {});

}  // namespace meanvalue
