// The workspaces of one bound mesh, as many as solves run at once.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/decoder.h"

namespace meanvalue {

/// Lends each solve a workspace of its own, and the one that remembers the answer that it goes on from, if there is
/// one: so that several drags at once, or one after another, each have the results that they would have alone. Of
/// those that nobody uses it keeps what 512 MB hold, at least two and at most eight; the longest unused goes first.
/// Safe to use from any thread, and in a forked child, which begins without any.
class WorkspacePool {
  public:
    explicit WorkspacePool(const Decoder& decoder);  ///< @pre it outlives the pool
    WorkspacePool(const WorkspacePool&) = delete;
    WorkspacePool& operator=(const WorkspacePool&) = delete;
    ~WorkspacePool();

    /// A workspace for as long as this lives.
    class Loan {
      public:
        /// @param previous the shape that the solve goes on from, n x 3 of the region; nullptr: it begins from rest.
        /// Waits for what a cancelled solve holds, which may be the drag to go on with. @throws Cancelled,
        /// std::bad_alloc.
        Loan(WorkspacePool& pool, const Positions* previous, const Execution& execution);
        Loan(const Loan&) = delete;
        Loan& operator=(const Loan&) = delete;
        ~Loan();

        Workspace& workspace() { return *workspace_; }

      private:
        WorkspacePool& pool_;
        const Execution& execution_;
        std::unique_ptr<Workspace> workspace_;
    };

    /// Of one workspace, once all of it is in use.
    std::size_t bytes_of_each(const Execution& execution);

  private:
    struct State {
        std::mutex mutex;
        std::condition_variable returned;
        std::vector<std::unique_ptr<Workspace>> idle;  // the longest unused first
        std::vector<const Execution*> running;         // of the solves that have one
        unsigned generation;                           // fork_generation() when it was made
    };

    State& state();
    std::unique_ptr<Workspace> take(const Positions* previous, const Execution& execution);
    void give_back(std::unique_ptr<Workspace> workspace, const Execution& execution);

    const Decoder& decoder_;
    std::atomic<State*> state_;
};

}  // namespace meanvalue
