// Which frames of a clip are solved in which run.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/sequence/sequence.h"
#include "meanvalue/sequence/trajectories.h"

namespace meanvalue {

/// Run r has frames [r chunk, (r + 1) chunk) of the clip, wherever the wanted ones begin and end. All but the first
/// begin earlier, for the seam with the one before; runs without a wanted frame of their own are solved for that
/// alone.
class RunPlan {
  public:
    /// @throws InvalidInput for options out of range and weights that are none, Cancelled. Cost: a look at the
    /// weights of each frame, and at the targets where runs begin.
    RunPlan(const BoundMesh& bound, const Trajectories& trajectories, const SequenceOptions& options,
            const Execution& execution);

    Index begin() const { return begin_; }  ///< of the wanted frames
    Index end() const { return end_; }
    bool is_wanted(Index frame) const { return begin_ <= frame && frame < end_; }

    Index first_run() const { return first_run_; }
    Index run_count() const { return static_cast<Index>(begins_.size()); }
    Index overlap() const { return overlap_; }
    /// The frame that the run before fades into this one in front of; for that behind the last run, too.
    std::int64_t seam_before(Index run) const { return std::int64_t{run} * chunk_; }
    /// So much earlier that it has a shape before it comes to frames that can't be solved; 0 where none can before.
    Index begin_of(Index run) const { return begins_[run - first_run_]; }
    Index end_of(Index run) const;
    /// End of the frames that what is wanted of a run depends on: smoothing looks so far ahead.
    Index end_to_solve(Index run) const;
    std::int64_t frames_to_solve() const { return frames_to_solve_; }  ///< of all runs

  private:
    void check(const BoundMesh& bound, const SequenceOptions& options, const Execution& execution) const;
    Index find_begin(const BoundMesh& bound, Index run) const;

    const Trajectories& trajectories_;
    Index chunk_;
    Index overlap_;
    Index begin_ = 0;
    Index end_ = 0;
    Index first_run_ = 0;
    std::vector<Index> begins_;  // of each run
    std::int64_t frames_to_solve_ = 0;
};

}  // namespace meanvalue
