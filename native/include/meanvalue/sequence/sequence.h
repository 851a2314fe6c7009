// Many frames over one bound mesh: anchors follow trajectories, and the mesh is found at every frame.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue {

/// Where the anchors go at each frame of a clip, in the order of the anchors.
struct Trajectories {
    Index frame_count = 0;
    Index anchor_count = 0;
    std::vector<double> targets;  ///< frames x anchors x 3
    std::vector<double> weights;  ///< frames x anchors, or empty: SolveOptions::weights of each frame
};

struct SequenceOptions {
    std::optional<double> tolerance;  ///< as of SolveOptions, and the next
    int max_iterations = 1000;
    /// Frames [first, second) are wanted; none: all of the clip.
    std::optional<std::pair<Index, Index>> frames;
    /// Frames are solved in runs of so many, each frame from the one before, the first of a run from rest: so that
    /// runs are solved side by side, and in part, with the same bits.
    Index chunk = 48;
    /// Each run but the first begins so many frames earlier, and over these the one before it fades into it: where
    /// two runs came to different minima, nothing jumps. At most `chunk`. Where a shape snaps inside a run, that is
    /// spread over so many frames to either side at most (RunPaths).
    Index overlap = 12;
    /// Ascending: frames, such as an artist's keys, that no snap beside them is spread over.
    std::vector<Index> kept;
    int threads = 0;  ///< 0: every core; results do not depend on it
    /// The shares of Execution::progress() that this call begins and ends at.
    std::pair<double, double> progress = {0.0, 1.0};
};

struct FrameFailure {
    Index frame;
    std::string message;
};

/// The wanted frames, in order.
struct Sequence {
    Index first = 0;  ///< number of the first in the clip
    Index vertex_count = 0;
    Index frame_count = 0;
    std::unique_ptr<float[]> vertices;  ///< frames x n x 3
    std::vector<double> energies;       ///< as Solution::energy, before snaps are spread and a frame fades into
                                        ///< another run's; NaN: failed
    std::vector<int> iterations;        ///< all_iterations
    std::vector<char> converged;
    std::vector<Index> snaps;  ///< ascending: frames that a shape snaps at, by 2 % of the diagonal or more, from the
                               ///< frame before; some frames to either side are spread over that
    std::vector<FrameFailure> failures;  ///< frames that could not be solved: they have the shape of the last that
                                         ///< could, or of rest where none could before
};

/// Section 4.2 of the paper. A frame's bits depend on the trajectories, `chunk` and `overlap` alone: neither on which
/// frames are wanted nor on the number of threads.
///
/// Where a shape snaps or two runs fade, frames are not at their minimum, but on the surface's own way between two:
/// their energy is 5 % above it at most, but for what it takes to go over a ridge. All others are as they were
/// solved.
///
/// Memory: what is returned, a workspace for each thread, and the overlap of each run.
/// @throws InvalidInput for options out of range, weights outside [0, 1] and trajectories of another number of
/// anchors, Cancelled; frames whose targets can't be solved are listed in `failures`.
Sequence solve_sequence(const Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                        Execution& execution);
inline Sequence solve_sequence(const Deformer& deformer, const Trajectories& trajectories,
                               const SequenceOptions& options = {}) {
    Execution execution;
    return solve_sequence(deformer, trajectories, options, execution);
}

}  // namespace meanvalue
