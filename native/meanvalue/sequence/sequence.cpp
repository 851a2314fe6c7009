#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/sequence/sequence_solve.h"
#include "meanvalue/sequence/smooth_paths.h"

namespace meanvalue {
namespace {

// A solve from rest ends when the energy falls slowly; where it lies in a valley, solves from its answer go on.
constexpr int kSolvesFromRest = 3;
// Roughness of the paths of vertices that is left alone, as a share of the diagonal: it can't be seen.
constexpr double kUnseen = 2e-5;
// Of a coordinate in the result, which is single precision: with room for differences and what smoothing adds.
constexpr double kMostCoordinate = std::numeric_limits<float>::max() / 8.0;

/// @throws InvalidInput.
void require_single_precision(const Positions& shape, const char* name) {
    const double most = shape.rows() > 0 ? shape.cwiseAbs().maxCoeff() : 0.0;
    if (most <= kMostCoordinate) return;
    throw InvalidInput(message(name, " has coordinates up to ", most, ", but frames are in single precision; scale ",
                               "mesh and targets so that they stay below ", kMostCoordinate));
}

void put(const Positions& shape, float* to) {
    std::transform(shape.data(), shape.data() + shape.size(), to, [](double x) { return static_cast<float>(x); });
}

}  // namespace

SequenceSolve::SequenceSolve(const Deformer& deformer, const Trajectories& trajectories,
                             const SequenceOptions& options, Execution& execution)
    : deformer_(deformer),
      trajectories_(trajectories),
      options_(options),
      execution_(execution),
      plan_(deformer.bound(), trajectories, options, execution) {
    const Positions& rest = deformer.bound().rest();
    require_single_precision(rest, "the rest shape");
    if (rest.rows() > 0) unseen_ = kUnseen * (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm();
    result_.first = plan_.begin();
    result_.vertex_count = deformer.report().vertex_count;
    const auto count = static_cast<std::size_t>(plan_.end() - plan_.begin());
    result_.frame_count = plan_.end() - plan_.begin();
    // Without writing to it: gigabytes take longer than a cancel may wait, and each frame is written anyway.
    result_.vertices.reset(new float[count * static_cast<std::size_t>(result_.vertex_count) * 3]);
    result_.energies.assign(count, std::numeric_limits<double>::quiet_NaN());
    result_.iterations.resize(count);
    result_.converged.resize(count);
}

template <typename Threads>
void SequenceSolve::solve_run(Run& run, const Threads& threads) {
    Seam& seam_before = *seams_[run.number - plan_.first_run()];
    Seam& seam_behind = *seams_[run.number - plan_.first_run() + 1];
    Execution of_run(&execution_);
    {
        std::optional<Deformer::Drag> drag;
        drag.emplace(deformer_);
        Positions shape(0, 3);  // empty until a frame could be solved
        for (Index frame = run.begin; frame < run.end; ++frame) {
            const bool is_told = is_told_by(run, frame);
            float* const to = add_frame(run, is_told);
            run.is_solved.push_back(static_cast<char>(solve_frame(drag, frame, is_told, threads(), of_run, shape)));
            put(shape_or_rest(shape), to);
            ++frames_solved_;
            report_progress();
        }
    }
    smooth(run);
    const auto first = static_cast<Index>(std::max<std::int64_t>(0, seam_before.at() - plan_.overlap()));
    for (Index frame = std::max(first, run.begin); frame < std::min<std::int64_t>(seam_before.at(), run.end);
         ++frame) {
        const Index place = frame - run.begin;
        if (plan_.is_wanted(frame) && run.is_solved[place]) seam_before.add(frame, std::move(run.aside[place]));
    }
    run.finish();
    for (Seam* const seam : {&seam_before, &seam_behind})
        seam->close(plan_.overlap(), numbers_of_shape(), [&](Index frame) { return row(frame); });
}

Sequence SequenceSolve::run() {
    if (plan_.run_count() == 0) return std::move(result_);
    const Index end_of_runs = plan_.first_run() + plan_.run_count();
    for (Index run = plan_.first_run(); run <= end_of_runs; ++run)
        seams_.push_back(std::make_unique<Seam>(plan_.seam_before(run)));
    for (Index run = plan_.first_run(); run < end_of_runs; ++run) {
        Run& added = runs_.emplace_back();
        added.number = run;
        added.begin = plan_.begin_of(run);
        added.end = plan_.end_to_solve(run);
    }
    const int threads = thread_count(options_.threads);
    const int workers = std::min<int>(threads, plan_.run_count());
    std::atomic<Index> next{plan_.first_run()};
    std::atomic<int> active{workers};
    execution_.begin_stage("solve");
    report_progress();
    run_workers(workers, [&](int) {
        try {
            for (Index run = next++; run < end_of_runs; run = next++)
                solve_run(runs_[run - plan_.first_run()],
                          [&] { return std::max(1, threads / std::max(1, active.load())); });
        } catch (...) {
            next = end_of_runs;  // the others need not begin another
            --active;
            throw;
        }
        --active;
    });
    carry_loose_parts(threads);
    std::sort(result_.failures.begin(), result_.failures.end(),
              [](const FrameFailure& a, const FrameFailure& b) { return a.frame < b.frame; });
    return std::move(result_);
}

/// Whether a frame of the result is this run's, at which others may only fade into it.
bool SequenceSolve::is_told_by(const Run& run, Index frame) const {
    return frame >= plan_.seam_before(run.number) && frame < plan_.end_of(run.number) && plan_.is_wanted(frame);
}

/// Room for the next frame of a run.
float* SequenceSolve::add_frame(Run& run, bool in_result) {
    const std::size_t numbers = numbers_of_shape();
    const Index frame = run.begin + static_cast<Index>(run.shapes.size());
    run.aside.emplace_back(in_result ? nullptr : new float[numbers]);
    run.shapes.push_back(in_result ? row(frame) : run.aside.back().get());
    return run.shapes.back();
}

/// From the first frame that could be solved on, as rough as the targets are; frames that could not be solved
/// hold what becomes of the one before.
void SequenceSolve::smooth(Run& run) {
    const auto first =
        static_cast<Index>(std::find(run.is_solved.begin(), run.is_solved.end(), char{1}) - run.is_solved.begin());
    const Index half_width = std::min<Index>(plan_.overlap(), plan_.end_of(run.number) - 1 - (run.begin + first));
    if (run.begin + first >= plan_.end() || half_width < 2) return;
    const std::vector<float*> shapes(run.shapes.begin() + first, run.shapes.end());
    const PathSmoother smoother({run.is_solved.begin() + first, run.is_solved.end()}, half_width);
    PathSmoother::Limits limits =
        smoother.roughness_of(trajectories_, run.begin + first, deformer_.bound().anchors(), shapes);
    for (std::vector<double>* const each : {&limits.wide, &limits.near})
        for (double& limit : *each)
            limit += unseen_;
    smoother.smooth(shapes, static_cast<std::size_t>(result_.vertex_count), limits, execution_);
    for (std::size_t k = 1; k < shapes.size(); ++k) {
        if (!run.is_solved[first + k]) std::copy_n(shapes[k - 1], numbers_of_shape(), shapes[k]);
    }
}

/// @param shape of the last frame that could be solved, or empty; receives this one's. @return whether it could.
bool SequenceSolve::solve_frame(std::optional<Deformer::Drag>& drag, Index frame, bool is_told, int threads,
                                Execution& execution, Positions& shape) {
    SolveOptions options;
    options.tolerance = options_.tolerance;
    options.max_iterations = options_.max_iterations;
    options.weights = trajectories_.weights_at(frame);
    options.threads = threads;
    const auto fail = [&](const std::exception& error) {
        if (!is_told) return false;
        const std::lock_guard<std::mutex> lock(mutex_);
        result_.failures.push_back({frame, error.what()});
        return false;
    };
    try {
        int iterations = 0;
        Solution solution;
        for (int left = shape.rows() > 0 ? 1 : kSolvesFromRest; left > 0; --left) {
            solution = drag->solve(trajectories_.targets_at(frame), options, execution);
            iterations += solution.all_iterations;
        }
        try {
            require_single_precision(solution.vertices, "the solved shape");
        } catch (const InvalidInput&) {  // the next frame begins at the last good one
            drag.emplace(deformer_, shape.rows() > 0 ? std::optional<PositionsView>(shape) : std::nullopt);
            throw;
        }
        shape = std::move(solution.vertices);
        if (!is_told) return true;
        const auto row = static_cast<std::size_t>(frame - plan_.begin());
        result_.energies[row] = solution.energy;
        result_.iterations[row] = iterations;
        result_.converged[row] = static_cast<char>(solution.converged);
        return true;
    } catch (const InvalidInput& error) {
        return fail(error);
    } catch (const SolverFailure& error) {
        return fail(error);
    }
}

/// Where paths were smoothed or faded, as what carries them is now.
void SequenceSolve::carry_loose_parts(int threads) {
    const BoundMesh& bound = deformer_.bound();
    if (bound.loose_parts().carriers().empty()) return;
    for (Index frame = plan_.begin(); frame < plan_.end(); ++frame)
        bound.loose_parts().carry(bound.rest(), row(frame), threads, execution_);
}

void SequenceSolve::report_progress() {
    const double share = static_cast<double>(frames_solved_) / static_cast<double>(plan_.frames_to_solve());
    execution_.set_progress(options_.progress.first + share * (options_.progress.second - options_.progress.first));
}

Sequence solve_sequence(const Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                        Execution& execution) {
    return SequenceSolve(deformer, trajectories, options, execution).run();
}

}  // namespace meanvalue
