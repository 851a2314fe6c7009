#include "meanvalue/morph/morpher.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/detached_job.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/morph/bound_shapes.h"

namespace meanvalue {
namespace {

constexpr double kDefaultTolerance = 1e-4;  // of the diagonal, of a single step: that of the fast method
// Iterations that lower the energy by less than so many step tolerances, as a share of it, end a solve.
constexpr double kEnergyTolerance = 50.0;
// A step so much shorter than the tolerance is the last: at a shape itself, what falls is rounding.
constexpr double kNegligible = 0.3;
// Of drafts; and they begin where the last solve ended if no more of all weight has moved since.
constexpr double kDraftTolerance = 3e-3;
constexpr double kNearWeights = 0.25;
// Of a draft: near a shape with sharp joints it would be dozens; what is left is for the next frame.
constexpr int kDraftIterations = 4;
constexpr std::size_t kMostIdle = 2;

/// Diagonals of the shapes at the size that they are put together at.
std::vector<double> sizes_over(std::vector<double> diagonals, const std::vector<double>& sizes) {
    for (std::size_t k = 0; k < diagonals.size(); ++k)
        diagonals[k] *= sizes[k];
    return diagonals;
}

}  // namespace

bool LastSolve::is_near(const ShapeWeights& others) const {
    if (weights.empty() || !others.is_uniform()) return false;
    double moved = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k)
        moved += 0.5 * std::abs(weights[k] - others.mean()[k]);
    return moved < kNearWeights;
}

/// One solve.
class Morpher::Solve {
  public:
    Solve(const Bound& bound, Workspace& work, const ShapeWeights& weights, const MorphOptions& options,
          Execution& execution)
        : bound_(bound),
          work_(work),
          weights_(weights),
          options_(options),
          execution_(execution),
          threads_(options.threads > 0 ? thread_count(options.threads) : bound.threads),
          overlay_(bound.overlay(weights, options.parts, execution)),
          size_(TurnedCells::geometric_mean(sizes_over(bound.diagonals, overlay_.sizes), weights.mean().data())) {}

    Solution run(const std::optional<PositionsView>& start) {
        Solution solution;
        {
            const StageTimer timer(solution.timings, "total");
            blend(solution.timings);
            Positions guess = assemble(solution.timings);
            solution.vertices = guess;
            follows_ = !start && options_.is_draft && work_.last.is_near(weights_);
            work_.last.weights.clear();  // of a cancelled solve nothing is kept
            if (start) {
                for (const Index v : bound_.unknowns.free)
                    solution.vertices.row(v) = start->row(v);
            }
            hold_at(guess);
            minimise(solution);
            if (weights_.is_uniform()) {
                work_.last.correction = solution.vertices - guess;
                work_.last.weights = weights_.mean();
            }
            if (bound_.springs.empty()) bound_.place(guess, {}, true, solution.vertices);
            bound_.take_along(weights_, threads_, execution_, solution.vertices);
        }
        return solution;
    }

  private:
    /// The averages that the energy is made of.
    void blend(Timings& timings) {
        const StageTimer timer(timings, "blend");
        execution_.begin_stage("blend");
        bound_.encodings->fill(weights_, threads_, execution_, work_.encoding);
        bound_.cells->fill(weights_, overlay_.sizes, overlay_.frames, overlay_.turn, threads_, execution_,
                           work_.rotations, work_.cells);
    }

    /// The turned cells put together and placed.
    Positions assemble(Timings& timings) {
        const StageTimer timer(timings, "assemble");
        const Positions linear = bound_.linear_blend(weights_, overlay_, threads_, execution_);
        Positions positions = linear;
        bound_.assembly->solve(work_.cells, work_.rotations, threads_, execution_, work_.assembly, positions);
        bound_.place(linear, overlay_.counts, false, positions);
        bound_.take_along(weights_, threads_, execution_, positions);
        return positions;
    }

    void hold_at(const Positions& guess) {
        const SoftConstraints& springs = work_.energy->soft_constraints();
        if (!springs.empty()) work_.energy_room.soft_targets = springs.rows_of(guess);
    }

    void minimise(Solution& solution) {
        execution_.begin_stage("solve");
        solution.stop_reason = "no free vertices";
        solution.energies = {0.0};
        solution.converged = true;
        if (bound_.unknowns.free.empty()) return;
        const StageTimer timer(solution.timings, "minimise");
        work_.energy->refill(work_.cells, size_, threads_, execution_);
        LbfgsOptions options;
        const double tolerance = options_.tolerance.value_or(options_.is_draft ? kDraftTolerance : kDefaultTolerance);
        options.step_tolerance = tolerance * size_;
        options.negligible_step = kNegligible * options.step_tolerance;
        options.energy_tolerance = bound_.rigidity > 0.0 ? kEnergyTolerance * tolerance : 0.0;
        options.max_iterations =
            options_.is_draft ? std::min(kDraftIterations, options_.max_iterations) : options_.max_iterations;
        options.threads = threads_;
        const LbfgsReport report = follows_ ? go_on(options, solution.vertices) : go_down(options, solution.vertices);
        solution.energies = report.energies;
        solution.initial_energy = report.energies.front();
        solution.energy = report.energies.back();
        solution.initial_gradient = report.initial_gradient;
        solution.gradient = report.gradient;
        solution.iterations = solution.all_iterations = report.iterations();
        solution.converged = report.converged;
        solution.stop_reason = report.converged  ? "converged"
                               : report.at_limit ? "iteration limit"
                                                 : "no step lowers the energy further";
    }

    double energy_at(const Positions& positions, Positions& gradient) {
        return work_.energy->evaluate(positions, bound_.rigidity, gradient, threads_, execution_, work_.energy_room);
    }

    LbfgsReport go_down(const LbfgsOptions& options, Positions& positions) {
        return work_.minimiser.minimise(
            [this](const Positions& at, Positions& gradient) { return energy_at(at, gradient); },
            {bound_.factor, work_.assembly.factor}, options, positions, execution_);
    }

    /// From the last correction where that is nearer than `positions`, where the cells are: towards a shape itself
    /// these come to need none.
    LbfgsReport go_on(const LbfgsOptions& options, Positions& positions) {
        LbfgsOptions going_on = options;
        going_on.keep_history = true;
        going_on.highest_start = energy_at(positions, work_.gradient);
        Positions nearer = positions + work_.last.correction;
        LbfgsReport report = go_down(going_on, nearer);
        if (report.is_refused) return go_down(options, positions);
        positions = std::move(nearer);
        return report;
    }

    const Bound& bound_;
    Workspace& work_;
    const ShapeWeights& weights_;
    const MorphOptions& options_;
    Execution& execution_;
    int threads_;
    Bound::Overlay overlay_;
    double size_;
    bool follows_ = false;  // begins where the last solve ended
};

Morpher::Morpher(const MorphBinding& binding, Execution& execution)
    : bound_(std::make_unique<const Bound>(binding, execution)) {
    report_.shape_count = static_cast<Index>(bound_->shapes.size());
    report_.vertex_count = static_cast<Index>(bound_->shapes[0].rows());
    report_.component_count = static_cast<Index>(bound_->parts.members.size());
    report_.guarded = bound_->encodings->layout().guarded;
    report_.timings = bound_->timings;
    idle_.push_back(std::make_unique<Workspace>(*bound_, execution));
    report_.bytes = bound_->bytes() + idle_.back()->bytes();
}

Morpher::~Morpher() = default;

Solution Morpher::solve(const std::vector<double>& weights, const std::optional<PositionsView>& start,
                        const MorphOptions& options, Execution& execution) const {
    const ShapeWeights normalised(weights, report_.shape_count, report_.vertex_count);
    if (options.tolerance && !(*options.tolerance > 0.0))
        throw InvalidInput(message("tolerance is ", *options.tolerance, "; give a positive number"));
    if (options.max_iterations < 0)
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    if (start) require_start(*start, bound_->shapes[0], bound_->diagonals[0], bound_->is_fixed, execution);
    std::unique_ptr<Workspace> workspace = take_workspace(execution);
    try {
        Solution solution = Solve(*bound_, *workspace, normalised, options, execution).run(start);
        give_back(std::move(workspace));
        return solution;
    } catch (...) {  // all that the next solve reads is written anew, or marked as not there
        give_back(std::move(workspace));
        throw;
    }
}

/// Without waiting: in a forked child the lock may be held for good.
std::unique_ptr<Morpher::Workspace> Morpher::take_workspace(const Execution& execution) const {
    {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock && !idle_.empty()) {
            std::unique_ptr<Workspace> workspace = std::move(idle_.back());
            idle_.pop_back();
            return workspace;
        }
    }
    return std::make_unique<Workspace>(*bound_, execution);
}

void Morpher::give_back(std::unique_ptr<Workspace> workspace) const {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && idle_.size() < kMostIdle) idle_.push_back(std::move(workspace));
}

std::unique_ptr<Morpher> bind_morph_detached(const MorphBinding& binding,
                                             const std::shared_ptr<Execution>& execution) {
    struct Bind {
        std::vector<Positions> shapes;
        Triangles faces;
        std::unique_ptr<MorphBinding> binding;
        std::shared_ptr<Execution> execution;
        std::unique_ptr<Morpher> morpher;
    };
    const auto bind = std::make_shared<Bind>();
    bind->faces = binding.faces;
    bind->execution = execution;
    for (const PositionsView& shape : binding.shapes)
        bind->shapes.emplace_back(shape);
    bind->binding = std::make_unique<MorphBinding>(MorphBinding{
        {}, bind->faces, binding.anchors, binding.rigidity, binding.hold, binding.threads, binding.instructions});
    for (const Positions& shape : bind->shapes)
        bind->binding->shapes.emplace_back(shape);
    run_detached([bind] { bind->morpher = std::make_unique<Morpher>(*bind->binding, *bind->execution); }, *execution);
    return std::move(bind->morpher);
}

}  // namespace meanvalue
