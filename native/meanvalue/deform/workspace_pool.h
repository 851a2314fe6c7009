// The workspaces of one bound mesh, as many as solves run at once.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/decode/decoder.h"

namespace meanvalue {

/// Lends each solve a workspace of its own; results do not depend on which. It keeps as many
/// unused ones as 512 MB hold, at least two and at most eight. Safe to use from any thread. It never waits: in a
/// forked child the lock may be held for ever, and then each solve has a new workspace.
class WorkspacePool {
  public:
    explicit WorkspacePool(const Decoder& decoder) : decoder_(decoder) {}  ///< @pre it outlives the pool

    /// A workspace for as long as this lives.
    class Loan {
      public:
        /// @throws Cancelled, std::bad_alloc.
        Loan(WorkspacePool& pool, const Execution& execution) : pool_(pool), workspace_(pool.take(execution)) {}
        Loan(const Loan&) = delete;
        Loan& operator=(const Loan&) = delete;
        ~Loan() { pool_.give_back(std::move(workspace_)); }

        Workspace& workspace() { return *workspace_; }

      private:
        WorkspacePool& pool_;
        std::unique_ptr<Workspace> workspace_;
    };

  private:
    std::unique_ptr<Workspace> take(const Execution& execution);
    void give_back(std::unique_ptr<Workspace> workspace);

    const Decoder& decoder_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace meanvalue
