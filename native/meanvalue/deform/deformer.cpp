#include "meanvalue/deform/deformer.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/deform/bound_mesh.h"

namespace meanvalue {
namespace {

using Workspaces = std::vector<std::unique_ptr<Workspace>>;  // of the parts

Workspaces make_workspaces(const BoundMesh& bound, const Execution& execution) {
    Workspaces workspaces;
    for (const BoundPart& part : bound.parts())
        workspaces.push_back(part.decoder->make_workspace(execution));
    return workspaces;
}

/// Adds what a part did: sums, and the most iterations of any.
void add(const DecodeReport& part, Solution& solution) {
    const std::vector<double>& energies = part.energies;
    solution.part_energies.push_back(energies.back());
    const double last = solution.energies.empty() ? 0.0 : solution.energies.back();
    solution.energies.resize(std::max(solution.energies.size(), energies.size()), last);
    for (std::size_t k = 0; k < solution.energies.size(); ++k)
        solution.energies[k] += energies[std::min(k, energies.size() - 1)];
    solution.initial_gradient = std::hypot(solution.initial_gradient, part.initial_gradient);
    solution.gradient = std::hypot(solution.gradient, part.gradient);
    if (solution.converged && (part.all_iterations >= solution.all_iterations || !part.converged))
        solution.stop_reason = part.stop_reason;
    solution.converged = solution.converged && part.converged;
    solution.iterations = std::max(solution.iterations, part.iterations);
    solution.all_iterations = std::max({solution.all_iterations, part.iterations, part.all_iterations});
    for (const auto& [stage, seconds] : part.timings)
        solution.timings[stage] += seconds;
}

/// @param shapes of the parts that the solve begins at, or none: at rest; receive those of the result. After an
/// exception they are where they were, and the workspaces remember no new answer.
Solution solve_with(const BoundMesh& bound, const Workspaces& workspaces, bool in_drag, const PositionsView& targets,
                    std::vector<Positions>& shapes, const SolveOptions& options, Execution& execution) {
    const double tolerance = options.tolerance.value_or(bound.default_tolerance());
    if (!(tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", tolerance, "; give a positive number"));
    }
    if (options.max_iterations < 0) {
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    }
    const std::vector<double>& enough = options.enough_energies;
    if (!enough.empty()) require_count("enough_energies", enough.size(), "number", bound.parts().size(), "parts");
    const std::vector<double>& weights = options.weights;
    const Positions filled = bound.targets_without_gaps(targets, weights);
    const PositionsView filled_view = filled;
    const int threads = bound.threads_of(options.threads);
    Solution solution;
    std::vector<DecodeReport> reports(bound.parts().size());
    const bool is_cold = shapes.empty();
    std::vector<Positions> found(reports.size());
    DecodeOptions decode_options;
    decode_options.tolerance = tolerance;
    decode_options.max_iterations = options.max_iterations;
    decode_options.targets = &filled_view;
    decode_options.weights = weights.empty() ? nullptr : &weights;
    decode_options.in_drag = in_drag;
    decode_options.is_last = options.settle;
    decode_options.is_kept = options.is_kept;
    Timings total;
    {
        const StageTimer timer(total, "total");
        bound.for_parts("solve", threads, execution,
                        [&](std::size_t number, int threads_of_part, Execution& of_part) {
                            DecodeOptions part_options = decode_options;
                            if (!enough.empty()) part_options.enough_energy = enough[number];
                            part_options.threads = threads_of_part;
                            const BoundPart& part = bound.parts()[number];
                            const auto decode = [&](const Positions* previous, Positions& positions) {
                                part_options.previous = previous;
                                positions = bound.start_of(part, filled, previous, weights, threads_of_part, of_part);
                                return part.decoder->decode(part_options, *workspaces[number], positions, of_part);
                            };
                            const bool asks_rest = !is_cold && options.settle;
                            if (asks_rest) part_options.in_drag = part_options.is_last = false;  // roughly, at first
                            reports[number] = decode(is_cold ? nullptr : &shapes[number], found[number]);
                            if (!asks_rest) return;
                            const Positions near = found[number];
                            part_options.is_last = true;
                            DecodeReport fresh_report = decode(nullptr, found[number]);
                            if (reports[number].energies.back() < fresh_report.energies.back()) {
                                reports[number] = decode(&near, found[number]);
                            } else {
                                reports[number] = std::move(fresh_report);
                            }
                        });
    }
    solution.vertices = bound.whole_mesh(found, filled, threads);
    solution.example_weights = bound.example_weights(reports, threads);
    solution.converged = true;
    for (const DecodeReport& report : reports)
        add(report, solution);
    solution.initial_energy = solution.energies.front();
    solution.energy = solution.energies.back();
    solution.timings.merge(total);
    shapes = std::move(found);
    // Once all are done: what is canceled leaves the drag as it was.
    for (std::size_t number = 0; number < shapes.size(); ++number) {
        if (options.settle) workspaces[number]->forget();
        if (in_drag && !is_cold && !options.settle)
            bound.parts()[number].decoder->remember(shapes[number], *workspaces[number]);
    }
    return solution;
}

}  // namespace

struct Deformer::State {
    explicit State(std::unique_ptr<const BoundMesh> mesh) : bound(std::move(mesh)) {}

    /// Neither of these waits: in a forked child the lock may be held for ever.
    Workspaces take_workspaces(const Execution& execution) {
        {
            const std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
            if (lock && !idle.empty()) return std::exchange(idle, {});
        }
        return make_workspaces(*bound, execution);
    }
    void keep_workspaces(Workspaces workspaces) {
        const std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
        if (lock) idle = std::move(workspaces);
    }

    const std::shared_ptr<const BoundMesh> bound;
    std::mutex mutex;
    Workspaces idle;  // of the last solve, for the next: to take its memory again costs a part of one
};

struct Deformer::Drag::State {
    explicit State(std::shared_ptr<const BoundMesh> mesh) : bound(std::move(mesh)) {}

    const std::shared_ptr<const BoundMesh> bound;
    std::mutex mutex;
    std::vector<Positions> shapes;  // of the parts in the last answer
    std::mutex making;              // of the workspaces, which are there for good then
    Workspaces workspaces;
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
    Workspaces workspaces = state_->take_workspaces(execution);
    std::vector<Positions> shapes;
    if (start) shapes = bound().parts_of(*start, execution);
    Solution solution = solve_with(bound(), workspaces, false, targets, shapes, options, execution);
    state_->keep_workspaces(std::move(workspaces));
    return solution;
}

Deformer::Drag::Drag(const Deformer& deformer, const std::optional<PositionsView>& start)
    : state_(std::make_unique<State>(deformer.state_->bound)) {
    if (start) state_->shapes = deformer.bound().parts_of(*start, Execution());
}

Deformer::Drag::Drag(Drag&&) noexcept = default;
Deformer::Drag& Deformer::Drag::operator=(Drag&&) noexcept = default;
Deformer::Drag::~Drag() = default;

Solution Deformer::Drag::solve(const PositionsView& targets, const SolveOptions& options, Execution& execution) {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (state_->workspaces.empty()) {
        const std::lock_guard<std::mutex> lock_making(state_->making);
        state_->workspaces = make_workspaces(*state_->bound, execution);
    }
    return solve_with(*state_->bound, state_->workspaces, true, targets, state_->shapes, options, execution);
}

std::optional<Positions> Deformer::Drag::draft(const PositionsView& targets, int threads,
                                               const Execution& execution) const {
    const Workspaces* workspaces = nullptr;
    {
        const std::unique_lock<std::mutex> lock(state_->making, std::try_to_lock);
        if (lock && !state_->workspaces.empty()) workspaces = &state_->workspaces;
    }
    if (workspaces == nullptr) return {};
    const BoundMesh& bound = *state_->bound;
    const Positions filled = bound.targets_without_gaps(targets, {});
    const PositionsView filled_view = filled;
    DecodeOptions options;
    options.targets = &filled_view;
    options.threads = bound.threads_of(threads);
    std::vector<Positions> shapes;
    for (const BoundPart& part : bound.parts()) {
        Workspace& workspace = *(*workspaces)[shapes.size()];
        shapes.push_back(bound.start_of(part, filled, nullptr, {}, options.threads, execution));
        if (!part.decoder->draft(options, workspace, shapes.back(), execution)) return {};
    }
    return bound.whole_mesh(shapes, filled, options.threads);
}

}  // namespace meanvalue
