#include "meanvalue/sequence/sequence.h"

#include <algorithm>
#include <cmath>

#include "fuzz/entries.h"
#include "fuzz/odd_input.h"

namespace meanvalue::fuzz {
namespace {

Trajectories read_trajectories(Bytes& bytes, const Mesh& mesh, const Binding& binding) {
    Trajectories trajectories;
    trajectories.frame_count = bytes.below(6);
    trajectories.anchor_count = static_cast<Index>(binding.anchors.size()) + (bytes.once_in(64) ? 1 : 0);
    const bool has_weights = !binding.strengths.empty() && bytes.once_in(2);
    for (Index frame = 0; frame < trajectories.frame_count; ++frame) {
        Positions targets = read_targets(bytes, mesh, binding.anchors);
        targets.conservativeResize(trajectories.anchor_count, 3);
        if (targets.rows() != static_cast<Eigen::Index>(binding.anchors.size())) targets.setZero();
        trajectories.targets.insert(trajectories.targets.end(), targets.data(), targets.data() + targets.size());
        for (Index k = 0; has_weights && k < trajectories.anchor_count; ++k)
            trajectories.weights.push_back(bytes.once_in(64) ? bytes.number() : bytes.once_in(2) ? 1.0 : 0.0);
    }
    return trajectories;
}

SequenceOptions read_options(Bytes& bytes) {
    SequenceOptions options;
    options.tolerance = read_tolerance(bytes);
    options.max_iterations = std::min(20, read_max_iterations(bytes));  // of each of some dozens of solves
    if (bytes.once_in(4)) {
        const Index first = bytes.below(8) - 1;
        options.frames = {first, first + bytes.below(8)};
    }
    options.chunk = bytes.below(6);
    options.overlap = bytes.below(4) - (bytes.once_in(32) ? 1 : 0);
    options.threads = bytes.once_in(4) ? 2 : 1;
    return options;
}

void require_sequence(const Sequence& clip, Index vertex_count) {
    require(clip.vertex_count == vertex_count, "a clip is of the mesh");
    const std::size_t frames = clip.frame_count;
    require(clip.energies.size() == frames && clip.iterations.size() == frames && clip.converged.size() == frames,
            "each frame has its figures");
    const float* begin = clip.vertices.get();
    require(std::all_of(begin, begin + frames * vertex_count * 3, [](float value) { return std::isfinite(value); }),
            "every coordinate is a finite number");
    for (std::size_t k = 0; k < frames; ++k) {
        const auto is_this = [&](const FrameFailure& failure) {
            return failure.frame == clip.first + static_cast<Index>(k);
        };
        const bool has_failed = std::any_of(clip.failures.begin(), clip.failures.end(), is_this);
        require(has_failed == std::isnan(clip.energies[k]), "frames without an energy are told");
    }
}

}  // namespace

Outcome sequence(Bytes bytes) {
    const Mesh mesh = read_mesh(bytes);
    const Binding binding = read_binding(bytes, mesh);
    return outcome_of([&] {
        Execution execution;
        Deformer deformer(binding, execution);
        const Trajectories trajectories = read_trajectories(bytes, mesh, binding);
        const SequenceOptions options = read_options(bytes);
        const Sequence clip = solve_sequence(deformer, trajectories, options, execution);
        require_sequence(clip, mesh.vertex_count());
    });
}

}  // namespace meanvalue::fuzz
