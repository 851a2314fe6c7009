#include "meanvalue/deform/deformer.h"

#include <algorithm>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {

Solution::Solution() = default;
Solution::Solution(const Solution&) = default;
Solution::Solution(Solution&&) noexcept = default;
Solution& Solution::operator=(const Solution&) = default;
Solution& Solution::operator=(Solution&&) noexcept = default;
Solution::~Solution() = default;

Deformer::Deformer(const Binding& binding, Execution& execution, const Deformer* earlier)
    : bound_(binding, execution, earlier == nullptr ? nullptr : &earlier->bound_),
      workspaces_(bound_.decoder()),
      report_(bound_.report()) {
    report_.bytes += WorkspacePool::Loan(workspaces_, execution).workspace().bytes();
}

Solution Deformer::solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                         const SolveOptions& options, Execution& execution) const {
    WorkspacePool::Loan loan(workspaces_, execution);
    return solve_with(loan.workspace(), false, targets, start, options, execution);
}

Deformer::Drag::Drag(const Deformer& deformer, const std::optional<PositionsView>& start) : deformer_(deformer) {
    if (start) last_.emplace(*start);
}

Deformer::Drag::~Drag() {
    if (loan_) loan_->workspace().forget();
}

Solution Deformer::Drag::solve(const PositionsView& targets, const SolveOptions& options, Execution& execution) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!loan_) loan_.emplace(deformer_.workspaces_, execution);
    std::optional<PositionsView> start;
    if (last_) start.emplace(*last_);
    Solution solution = deformer_.solve_with(loan_->workspace(), true, targets, start, options, execution);
    last_ = solution.vertices;
    return solution;
}

Solution Deformer::solve_with(Workspace& workspace, bool in_drag, const PositionsView& targets,
                              const std::optional<PositionsView>& start, const SolveOptions& options,
                              Execution& execution) const {
    const double tolerance = options.tolerance.value_or(bound_.default_tolerance());
    if (!(tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", tolerance, "; give a positive number"));
    }
    if (options.max_iterations < 0) {
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    }
    const std::vector<double>& weights = options.weights;
    const Positions filled = bound_.targets_without_gaps(targets, weights);
    const PositionsView filled_view = filled;
    Solution solution;
    const int threads = bound_.threads_of(options.threads > 0 ? thread_count(options.threads) : 0);
    solution.vertices = bound_.place_anchors(filled, start, weights, threads, execution);
    Positions positions = bound_.rows_of_region(solution.vertices, threads, execution);
    const Positions previous = start ? bound_.rows_of_region(*start, threads, execution) : Positions();
    DecodeReport report;
    Timings total;
    {
        const StageTimer timer(total, "total");
        execution.begin_stage("solve");
        DecodeOptions decode_options;
        decode_options.tolerance = tolerance;
        decode_options.max_iterations = options.max_iterations;
        decode_options.previous = start ? &previous : nullptr;
        decode_options.targets = &filled_view;
        decode_options.weights = weights.empty() ? nullptr : &weights;
        decode_options.threads = threads;
        decode_options.in_drag = in_drag;
        decode_options.is_last = options.settle;
        const Decoder& decoder = bound_.decoder();
        report = decoder.decode(decode_options, workspace, positions, execution);
        if (start && options.settle) {
            Positions fresh = bound_.rows_of_region(bound_.place_anchors(filled, {}, weights, threads, execution),
                                                    threads, execution);
            decode_options.previous = nullptr;
            DecodeReport fresh_report = decoder.decode(decode_options, workspace, fresh, execution);
            if (fresh_report.energies.back() < report.energies.back()) {
                report = std::move(fresh_report);
                positions = std::move(fresh);
            }
        }
        // Once both are done: after a cancel the next frame goes on from the answer before.
        if (options.settle) workspace.forget();
    }
    bound_.put_rows_of_region(positions, solution.vertices, threads);
    bound_.loose_parts().carry(bound_.rest(), solution.vertices.data(), threads, execution);
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

}  // namespace meanvalue
