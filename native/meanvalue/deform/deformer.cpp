#include "meanvalue/deform/deformer.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/deform/bound_mesh.h"

namespace meanvalue {
namespace {

/// @param region the decoder's vertices that the solve begins at, none: at rest; receives those of the result.
Solution solve_with(const BoundMesh& bound, Workspace& workspace, bool in_drag, const PositionsView& targets,
                    std::optional<Positions>& region, const SolveOptions& options, Execution& execution) {
    const double tolerance = options.tolerance.value_or(bound.default_tolerance());
    if (!(tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", tolerance, "; give a positive number"));
    }
    if (options.max_iterations < 0) {
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    }
    const std::vector<double>& weights = options.weights;
    const Positions filled = bound.targets_without_gaps(targets, weights);
    const PositionsView filled_view = filled;
    const int threads = bound.threads_of(options.threads);
    const Positions* const previous = region ? &*region : nullptr;
    Positions positions = bound.start_of_region(filled, previous, weights, threads, execution);
    Solution solution;
    DecodeReport report;
    Timings total;
    {
        const StageTimer timer(total, "total");
        execution.begin_stage("solve");
        DecodeOptions decode_options;
        decode_options.tolerance = tolerance;
        decode_options.max_iterations = options.max_iterations;
        decode_options.enough_energy = options.enough_energy;
        decode_options.previous = previous;
        decode_options.targets = &filled_view;
        decode_options.weights = weights.empty() ? nullptr : &weights;
        decode_options.threads = threads;
        decode_options.in_drag = in_drag;
        decode_options.is_last = options.settle;
        decode_options.is_kept = options.is_kept;
        const Decoder& decoder = bound.decoder();
        const bool asks_rest = previous != nullptr && options.settle;
        if (asks_rest) decode_options.in_drag = decode_options.is_last = false;  // roughly, at first
        report = decoder.decode(decode_options, workspace, positions, execution);
        if (asks_rest) {
            const Positions near = positions;
            positions = bound.start_of_region(filled, nullptr, weights, threads, execution);
            decode_options.previous = nullptr;
            decode_options.is_last = true;
            DecodeReport fresh_report = decoder.decode(decode_options, workspace, positions, execution);
            if (report.energies.back() < fresh_report.energies.back()) {
                positions = bound.start_of_region(filled, &near, weights, threads, execution);
                decode_options.previous = &near;
                report = decoder.decode(decode_options, workspace, positions, execution);
            } else {
                report = std::move(fresh_report);
            }
        }
        // Once both are done: after a cancel the next frame goes on from the answer before.
        if (options.settle) workspace.forget();
    }
    solution.vertices = bound.whole_mesh(positions, filled, threads);
    solution.example_weights = bound.example_weights(report.example_weights, threads);
    region = std::move(positions);
    solution.energies = report.energies;
    solution.initial_energy = report.energies.front();
    solution.energy = report.energies.back();
    solution.initial_gradient = report.initial_gradient;
    solution.gradient = report.gradient;
    solution.iterations = report.iterations;
    solution.all_iterations = std::max(report.iterations, report.all_iterations);
    solution.converged = report.converged;
    solution.stop_reason = report.stop_reason;
    solution.timings = std::move(report.timings);
    solution.timings.merge(total);
    return solution;
}

}  // namespace

struct Deformer::State {
    explicit State(std::unique_ptr<const BoundMesh> mesh) : bound(std::move(mesh)) {}

    /// Neither of these waits: in a forked child the lock may be held for ever.
    std::unique_ptr<Workspace> take_workspace(const Execution& execution) {
        {
            const std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
            if (lock && idle) return std::move(idle);
        }
        return bound->decoder().make_workspace(execution);
    }
    void keep_workspace(std::unique_ptr<Workspace> workspace) {
        const std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
        if (lock) idle = std::move(workspace);
    }

    const std::shared_ptr<const BoundMesh> bound;
    std::mutex mutex;
    std::unique_ptr<Workspace> idle;  // of the last solve, for the next: to take its memory again costs a part of one
};

struct Deformer::Drag::State {
    explicit State(std::shared_ptr<const BoundMesh> mesh) : bound(std::move(mesh)) {}

    const std::shared_ptr<const BoundMesh> bound;
    std::mutex mutex;
    std::optional<Positions> region;  // of the last answer
    std::mutex making;                // of the workspace, which is there for good then
    std::unique_ptr<Workspace> workspace;
};

Deformer::Deformer(std::unique_ptr<const BoundMesh> bound) : state_(std::make_unique<State>(std::move(bound))) {}

Deformer::Deformer(const Binding& binding, Execution& execution, const Deformer* earlier,
                   const std::function<void(std::shared_ptr<Deformer>)>& when_coarse) {
    const auto hand_on = [&](std::unique_ptr<const BoundMesh> early) {
        when_coarse(std::shared_ptr<Deformer>(new Deformer(std::move(early))));
    };
    state_ = std::make_unique<State>(std::make_unique<const BoundMesh>(
        binding, execution, earlier == nullptr ? nullptr : &earlier->bound(),
        when_coarse ? hand_on : std::function<void(std::unique_ptr<const BoundMesh>)>()));
}

Deformer::Deformer(const Binding& binding) : Deformer(binding, *std::make_unique<Execution>()) {}

Deformer::Deformer(Deformer&&) noexcept = default;
Deformer& Deformer::operator=(Deformer&&) noexcept = default;
Deformer::~Deformer() = default;

Binding Deformer::binding_again() const {
    return bound().binding_again();
}

const BindReport& Deformer::report() const {
    return bound().report();
}

const BoundMesh& Deformer::bound() const {
    return *state_->bound;
}

Solution Deformer::solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                         const SolveOptions& options, Execution& execution) const {
    std::unique_ptr<Workspace> workspace = state_->take_workspace(execution);
    std::optional<Positions> region;
    if (start) region = bound().region_of(*start, bound().threads_of(options.threads), execution);
    Solution solution = solve_with(bound(), *workspace, false, targets, region, options, execution);
    state_->keep_workspace(std::move(workspace));
    return solution;
}

Deformer::Drag::Drag(const Deformer& deformer, const std::optional<PositionsView>& start)
    : state_(std::make_unique<State>(deformer.state_->bound)) {
    if (start) state_->region = deformer.bound().region_of(*start, deformer.bound().threads_of(0), Execution());
}

Deformer::Drag::Drag(Drag&&) noexcept = default;
Deformer::Drag& Deformer::Drag::operator=(Drag&&) noexcept = default;
Deformer::Drag::~Drag() = default;

Solution Deformer::Drag::solve(const PositionsView& targets, const SolveOptions& options, Execution& execution) {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (!state_->workspace) {
        const std::lock_guard<std::mutex> lock_making(state_->making);
        state_->workspace = state_->bound->decoder().make_workspace(execution);
    }
    return solve_with(*state_->bound, *state_->workspace, true, targets, state_->region, options, execution);
}

std::optional<Positions> Deformer::Drag::draft(const PositionsView& targets, int threads,
                                               const Execution& execution) const {
    Workspace* workspace = nullptr;
    {
        const std::unique_lock<std::mutex> lock(state_->making, std::try_to_lock);
        if (lock) workspace = state_->workspace.get();
    }
    if (workspace == nullptr) return {};
    const BoundMesh& bound = *state_->bound;
    const Positions filled = bound.targets_without_gaps(targets, {});
    const PositionsView filled_view = filled;
    DecodeOptions options;
    options.targets = &filled_view;
    options.threads = bound.threads_of(threads);
    Positions region = bound.start_of_region(filled, nullptr, {}, options.threads, execution);
    if (!bound.decoder().draft(options, *workspace, region, execution)) return {};
    return bound.whole_mesh(region, filled, options.threads);
}

}  // namespace meanvalue
