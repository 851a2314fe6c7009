#include "meanvalue/sequence/run_plan.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

void check_options(const BoundMesh& bound, const Trajectories& trajectories, const SequenceOptions& options,
                   const Execution& execution) {
    if (trajectories.anchor_count != bound.report().anchor_count) {
        throw InvalidInput(message("targets are of ", trajectories.anchor_count, " anchors, but the mesh has ",
                                   bound.report().anchor_count));
    }
    const auto wanted = std::int64_t{trajectories.frame_count} * trajectories.anchor_count;
    const auto targets = static_cast<std::int64_t>(trajectories.targets.size());
    const auto weights = static_cast<std::int64_t>(trajectories.weights.size());
    if (trajectories.frame_count < 0 || targets != 3 * wanted || (weights != 0 && weights != wanted)) {
        throw InvalidInput(message("there are ", trajectories.frame_count, " frames of ", trajectories.anchor_count,
                                   " anchors, but ", targets, " coordinates of targets and ", weights,
                                   " weights; give three and one for each anchor of each frame, or no weights"));
    }
    if (options.chunk < 1) throw InvalidInput(message("chunk is ", options.chunk, "; give 1 or more"));
    if (options.overlap < 0) throw InvalidInput(message("overlap is ", options.overlap, "; give 0 or more"));
    if (options.tolerance && !(*options.tolerance > 0.0))
        throw InvalidInput(message("tolerance is ", *options.tolerance, "; give a positive number"));
    if (options.max_iterations < 0)
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    for (Index frame = 0; !trajectories.weights.empty() && frame < trajectories.frame_count; ++frame) {
        execution.check_every(frame);
        try {
            bound.check_weights(weights_at(trajectories, frame));
        } catch (const InvalidInput& error) {
            throw InvalidInput(message("frame ", frame, ": ", error.what()));
        }
    }
    if (!std::is_sorted(options.kept.begin(), options.kept.end()))
        throw InvalidInput("kept is not ascending; sort it");
    if (!options.frames) return;
    const auto [begin, end] = *options.frames;
    if (begin < 0 || end < begin || end > trajectories.frame_count) {
        throw InvalidInput(message("frames is (", begin, ", ", end, "), but the clip has ", trajectories.frame_count,
                                   " frames, numbered from 0"));
    }
}

}  // namespace

RunPlan plan_runs(const BoundMesh& bound, const Trajectories& trajectories, const SequenceOptions& options,
                  const Execution& execution) {
    check_options(bound, trajectories, options, execution);
    const std::int64_t frame_count = trajectories.frame_count;
    const std::int64_t chunk = std::clamp<std::int64_t>(frame_count, 1, options.chunk);
    const auto frame_at = [&](std::int64_t frame) {
        return static_cast<Index>(std::clamp<std::int64_t>(frame, 0, frame_count));
    };
    RunPlan plan;
    plan.overlap = static_cast<Index>(std::min<std::int64_t>(options.overlap, chunk));
    std::tie(plan.begin, plan.end) = options.frames.value_or(std::pair<Index, Index>{0, trajectories.frame_count});
    if (plan.begin == plan.end) return plan;
    Index looked_at = 0, last_placed = -1;  // of the frames before
    const auto placed_before = [&](Index frame) {
        for (; looked_at < frame; ++looked_at) {
            try {
                bound.targets_without_gaps(targets_at(trajectories, looked_at), weights_at(trajectories, looked_at));
                last_placed = looked_at;
            } catch (const InvalidInput&) {  // the frame before is the last that can be solved
            }
        }
        return last_placed;
    };
    for (std::int64_t own_begin = plan.begin / chunk * chunk; own_begin < frame_count; own_begin += chunk) {
        execution.check();
        Run run;
        run.own_begin = frame_at(own_begin);
        run.own_end = frame_at(own_begin + chunk);
        run.end =
            frame_at(std::min<std::int64_t>(run.own_end, std::int64_t{plan.end} + plan.overlap + kFramesOfSnap));
        run.begin = frame_at(own_begin - plan.overlap);
        if (run.begin >= plan.end) break;
        const Index placed = placed_before(run.begin + 1);
        if (placed < run.begin) run.lead = placed;
        plan.runs.push_back(run);
    }
    return plan;
}

PositionsView targets_at(const Trajectories& trajectories, Index frame) {
    const Index anchors = trajectories.anchor_count;
    return Eigen::Map<const Positions>(trajectories.targets.data() + static_cast<std::size_t>(frame) * anchors * 3,
                                       anchors, 3);
}

std::vector<double> weights_at(const Trajectories& trajectories, Index frame) {
    if (trajectories.weights.empty()) return {};
    const auto first = trajectories.weights.begin() + static_cast<std::ptrdiff_t>(frame) * trajectories.anchor_count;
    return {first, first + trajectories.anchor_count};
}

}  // namespace meanvalue
