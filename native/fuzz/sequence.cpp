#include "meanvalue/sequence/sequence.h"

#include <algorithm>
#include <cmath>

#include "fuzz/entries.h"
#include "fuzz/odd_input.h"

namespace meanvalue::fuzz {
namespace {

Trajectories read_trajectories(Bytes& bytes, const OddMesh& mesh, const Binding& binding) {
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

std::vector<double> bits_of(const Sequence& clip) {
    std::vector<double> numbers(clip.vertices.get(),
                                clip.vertices.get() + std::size_t(clip.frame_count) * clip.vertex_count * 3);
    for (const double energy : clip.energies)
        numbers.push_back(std::isnan(energy) ? -1.0 : energy);
    numbers.insert(numbers.end(), clip.iterations.begin(), clip.iterations.end());
    numbers.insert(numbers.end(), clip.converged.begin(), clip.converged.end());
    for (const FrameFailure& failure : clip.failures)
        numbers.push_back(failure.frame);
    return numbers;
}

/// Something else than `state`.
Archive::Bytes damaged(Bytes& bytes, Archive::Bytes state) {
    const auto place_in = [&](std::size_t count) {
        const std::size_t low = bytes.below(65536);
        return (low + (std::size_t{65536} * bytes.byte())) % count;
    };
    switch (bytes.below(4)) {
        case 0:
            state.resize(std::max<std::size_t>(1, place_in(state.size())));
            break;
        case 1:
            state.insert(state.begin() + place_in(state.size()), 1 + bytes.below(16), bytes.byte());
            break;
        default:
            break;
    }
    const Archive::Bytes before = state;
    for (int more = bytes.below(4); more >= 0 || state == before; --more)
        state[place_in(state.size())] ^= 1U << bytes.below(8);
    return state;
}

/// Pauses it again and again at frames that `bytes` tell: what it is in the end.
Sequence solve_with_pauses(Bytes& bytes, Deformer& deformer, const Binding& binding, const Trajectories& trajectories,
                           SequenceOptions options) {
    options.may_pause = true;
    options.pause_after = -1;
    std::unique_ptr<Deformer> other;
    for (int pauses_left = 3;; --pauses_left) {
        Execution execution;
        options.pause_after += 1 + bytes.below(options.resume.empty() ? 8 : 4);
        if (pauses_left == 0) options.may_pause = false;
        if (bytes.once_in(4)) options.threads = 3 - options.threads;
        if (bytes.once_in(8)) other = std::make_unique<Deformer>(binding, execution);
        Sequence clip = solve_sequence(other ? *other : deformer, trajectories, options, execution);
        if (clip.state.empty()) return clip;
        require(pauses_left > 0, "who does not pause comes to the end");
        require(!clip.vertices && clip.solved.size() == static_cast<std::size_t>(clip.frame_count),
                "of a paused clip it is told which frames are solved, and nothing is shown");
        options.resume = std::move(clip.state);
        if (!bytes.once_in(2)) continue;
        SequenceOptions spoiled = options;
        spoiled.resume = damaged(bytes, options.resume);
        const auto go_on = [&] { solve_sequence(deformer, trajectories, spoiled, execution); };
        require(outcome_of(go_on) == Outcome::kRefused, "a damaged state is refused");
    }
}

}  // namespace

Outcome sequence(Bytes bytes) {
    const OddMesh mesh = read_mesh(bytes);
    const Binding binding = read_binding(bytes, mesh);
    return outcome_of([&] {
        Execution execution;
        Deformer deformer(binding, execution);
        const Trajectories trajectories = read_trajectories(bytes, mesh, binding);
        const SequenceOptions options = read_options(bytes);
        const Sequence clip = solve_sequence(deformer, trajectories, options, execution);
        require_sequence(clip, mesh.vertex_count());
        if (!bytes.once_in(3)) return;
        const Sequence paused = solve_with_pauses(bytes, deformer, binding, trajectories, options);
        require_sequence(paused, mesh.vertex_count());
        require(bits_of(paused) == bits_of(clip), "a clip has the bits that it would have without the pauses");
    });
}

}  // namespace meanvalue::fuzz
