// Which frames of a clip are solved in which run.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/sequence/sequence.h"

namespace meanvalue {

/// Frames that are solved one after another, each from the one before.
struct Run {
    Index begin = 0;      ///< of the frames to solve
    Index end = 0;        ///< of the frames to solve: snaps are looked for ahead of what is wanted
    Index lead = -1;      ///< the last before `begin` that can be solved, where that can't; -1: none
    Index own_begin = 0;  ///< the result has this run's frames from here on; the run before fades into them
    Index own_end = 0;
};

/// Run r owns the frames [r chunk, (r + 1) chunk) of the clip, whichever are wanted. All but the first begin earlier,
/// for the run before to fade into them; runs without a wanted frame of their own are solved for that alone.
struct RunPlan {
    Index begin = 0;  ///< of the wanted frames
    Index end = 0;
    Index overlap = 0;  ///< frames over which one run fades into the next
    std::vector<Run> runs;

    bool is_wanted(Index frame) const { return begin <= frame && frame < end; }
};

/// @throws InvalidInput for options out of range and weights outside [0, 1], Cancelled. Cost: linear in the weights.
RunPlan plan_runs(const BoundMesh& bound, const Trajectories& trajectories, const SequenceOptions& options,
                  const Execution& execution);

/// anchors x 3.
PositionsView targets_at(const Trajectories& trajectories, Index frame);
/// One for each anchor; empty where there are none.
std::vector<double> weights_at(const Trajectories& trajectories, Index frame);

}  // namespace meanvalue
