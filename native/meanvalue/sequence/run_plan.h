// Which frames of a clip are solved in which run, where a shape snaps in one, and how that is spread over some
// frames.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/binding_input.h"
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

/// A step between two frames by which some vertex goes farther than the steps around it and the targets explain: its
/// minimum ceased to be, or a loose solve catches up.
struct Snap {
    Index frame;    ///< of the run, the first one behind the step
    double length;  ///< the farthest that a vertex goes besides
    double share;   ///< 0 to 1: how sharp it is against what is around it. A swing is not
};

/// How many frames behind a snap, at most, say whether and how far it is one, with the steps beside its own.
constexpr Index kFramesOfSnap = 12;
constexpr double kTold = 2e-2;  ///< of the diagonal: snaps that go so far or farther are told

/// 0 to 1 with no slope at either end, and the least second difference. @param frame of `count`, counted from 0.
double fade(Index frame, Index count);

/// The paths of some vertices in the frames of one run.
class RunPaths {
  public:
    /// @param points of each frame, n x 3. @param vertices of these, the only ones that are read or moved.
    /// @param is_solved flag of each frame: nothing is known near others.
    RunPaths(std::vector<float*> points, std::vector<Index> vertices, std::vector<char> is_solved);

    /// What steps may exceed those around them by, for each frame: as far as any target of `anchors` does nearby, and
    /// a little. @param first the clip's frame that the run's first is. @param size the diagonal.
    std::vector<double> limits(const Trajectories& trajectories, const std::vector<AnchorOfRegion>& anchors,
                               Index first, double size) const;

    /// @param limits one for each frame. @throws Cancelled.
    std::vector<Snap> find_snaps(const std::vector<double>& limits, const Execution& execution) const;

    /// Spreads snaps over as few frames to either side as make them as smooth as the targets are, along straight
    /// lines.
    /// @param stays flag of each frame that keeps its shape. @param most_frames to either side.
    /// @return flag of each frame that was moved. @throws Cancelled.
    std::vector<char> spread(const std::vector<Snap>& snaps, const std::vector<double>& limits,
                             const std::vector<char>& stays, Index most_frames, const Execution& execution);

  private:
    Index radius_around(Index step) const;
    bool are_solved(Index begin, Index end) const;

    std::vector<float*> points_;
    std::vector<Index> vertices_;
    std::vector<char> is_solved_;
    Index frame_count_;
};

}  // namespace meanvalue
