#include "meanvalue/sequence/run_plan.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "meanvalue/common/errors.h"

namespace meanvalue {

RunPlan::RunPlan(const BoundMesh& bound, const Trajectories& trajectories, const SequenceOptions& options,
                 const Execution& execution)
    : trajectories_(trajectories),
      chunk_(std::min(options.chunk, std::max<Index>(1, trajectories.frame_count))),
      overlap_(std::min(options.overlap, chunk_)) {
    execution.check();
    check(bound, options, execution);
    std::tie(begin_, end_) = options.frames.value_or(std::pair<Index, Index>{0, trajectories.frame_count});
    if (begin_ == end_) return;
    first_run_ = begin_ / chunk_;
    Index last_run = (end_ - 1) / chunk_;
    const bool has_seam_behind = overlap_ > 0 && seam_before(last_run + 1) < trajectories.frame_count;
    if (has_seam_behind && end_ > seam_before(last_run + 1) - overlap_) ++last_run;
    for (Index run = first_run_; run <= last_run; ++run) {
        execution.check();
        begins_.push_back(find_begin(bound, run));
        frames_to_solve_ += end_to_solve(run) - begins_.back();
    }
}

void RunPlan::check(const BoundMesh& bound, const SequenceOptions& options, const Execution& execution) const {
    if (trajectories_.anchor_count != bound.report().anchor_count) {
        throw InvalidInput(message("targets are of ", trajectories_.anchor_count, " anchors, but the mesh has ",
                                   bound.report().anchor_count));
    }
    if (options.chunk < 1) throw InvalidInput(message("chunk is ", options.chunk, "; give 1 or more"));
    if (options.overlap < 0) throw InvalidInput(message("overlap is ", options.overlap, "; give 0 or more"));
    if (options.tolerance && !(*options.tolerance > 0.0))
        throw InvalidInput(message("tolerance is ", *options.tolerance, "; give a positive number"));
    if (options.max_iterations < 0)
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    for (Index frame = 0; !trajectories_.weights.empty() && frame < trajectories_.frame_count; ++frame) {
        execution.check_every(frame);
        try {
            bound.check_weights(trajectories_.weights_at(frame));
        } catch (const InvalidInput& error) {
            throw InvalidInput(message("frame ", frame, ": ", error.what()));
        }
    }
    if (!options.frames) return;
    const auto [begin, end] = *options.frames;
    if (begin < 0 || end < begin || end > trajectories_.frame_count) {
        throw InvalidInput(message("frames is (", begin, ", ", end, "), but the clip has ", trajectories_.frame_count,
                                   " frames, numbered from 0"));
    }
}

Index RunPlan::find_begin(const BoundMesh& bound, Index run) const {
    auto frame = static_cast<Index>(std::max<std::int64_t>(0, seam_before(run) - overlap_));
    while (frame > 0 && !bound.can_be_placed(trajectories_.targets_at(frame), trajectories_.weights_at(frame)))
        --frame;
    return frame;
}

Index RunPlan::end_of(Index run) const {
    return static_cast<Index>(std::min<std::int64_t>(trajectories_.frame_count, seam_before(run + 1)));
}

Index RunPlan::end_to_solve(Index run) const {
    return static_cast<Index>(std::min<std::int64_t>(end_of(run), std::int64_t{end_} + 2 * std::int64_t{overlap_}));
}

}  // namespace meanvalue
