#include "meanvalue/sequence/sequence.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/sequence/run_plan.h"

namespace meanvalue {
namespace {

// A frame that was moved from its minimum goes back towards it until its energy is so many times as high as there, or
// for so many iterations: where a snap goes over a ridge, there is no shape that is as good.
constexpr double kMostEnergy = 1.05;
constexpr int kMostSettling = 12;
constexpr double kWhatever = std::numeric_limits<double>::infinity();
// The largest coordinate of a result, which is in single precision; smoothing and differences need some room.
constexpr double kMostCoordinate = std::numeric_limits<float>::max() / 8.0;

/// @throws InvalidInput.
void require_single_precision(const Positions& shape, const char* name) {
    const double most = shape.rows() > 0 ? shape.cwiseAbs().maxCoeff() : 0.0;
    if (most <= kMostCoordinate) return;
    throw InvalidInput(message(name, " has coordinates up to ", most, ", but frames are in single precision; scale ",
                               "mesh and targets so that they stay below ", kMostCoordinate));
}

/// One call of solve_sequence(): solves runs side by side, spreads the snaps of each, fades each into the next, and
/// settles the frames that were moved by that.
class SequenceSolve {
  public:
    SequenceSolve(const Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                  Execution& execution)
        : deformer_(deformer),
          trajectories_(trajectories),
          options_(options),
          execution_(execution),
          plan_(plan_runs(deformer.bound(), trajectories, options, execution)),
          parts_(deformer.bound().parts()),
          overlaps_(plan_.runs.size()) {
        require_single_precision(deformer.bound().rest(), "the rest shape");
        result_.first = plan_.begin;
        result_.vertex_count = deformer.report().vertex_count;
        result_.frame_count = plan_.end - plan_.begin;
        const auto count = static_cast<std::size_t>(result_.frame_count);
        // Without writing to it: gigabytes take longer than a cancel may wait, and each frame is written anyway.
        result_.vertices.reset(new float[count * numbers_of_shape()]);
        result_.energies.assign(count, std::numeric_limits<double>::quiet_NaN());
        result_.iterations.resize(count);
        result_.converged.resize(count);
        energies_.resize(count);
        is_moved_.assign(count, std::vector<char>(parts_.size(), 0));
        for (const Run& run : plan_.runs)
            frames_to_solve_ += run.end - run.begin;
    }

    Sequence run() {
        const int threads = thread_count(options_.threads);
        const auto count = static_cast<int>(plan_.runs.size());
        std::atomic<int> unfinished{count};
        execution_.begin_stage("solve");
        execution_.set_progress(options_.progress.first);
        parallel_items(plan_.runs.size(), threads, execution_, [&](int, std::size_t number) {
            // Runs that are left share the threads of those that are done.
            solve_run(number, [&] { return std::max(1, threads / std::min(threads, unfinished.load())); });
            --unfinished;
        });
        for (std::size_t number = 0; number < plan_.runs.size(); ++number)
            fade_into(number);
        parallel_items(is_moved_.size(), threads, execution_,
                       [&](int, std::size_t row) { settle(row, is_moved_.size() > 1 ? 1 : threads); });
        std::sort(result_.snaps.begin(), result_.snaps.end());
        result_.snaps.erase(std::unique(result_.snaps.begin(), result_.snaps.end()), result_.snaps.end());
        carry_loose_parts(threads);
        std::sort(result_.failures.begin(), result_.failures.end(),
                  [](const FrameFailure& a, const FrameFailure& b) { return a.frame < b.frame; });
        return std::move(result_);
    }

  private:
    using Shape = std::unique_ptr<float[]>;

    /// The frames of a run, from `begin` on.
    struct Frames {
        std::vector<float*> shapes;  // in the result, or in `outside`
        std::vector<Shape> outside;  // none where it is in the result
        std::vector<char> is_solved;
    };

    std::size_t numbers_of_shape() const { return static_cast<std::size_t>(result_.vertex_count) * 3; }

    float* shape_in_result(Index frame) {
        return result_.vertices.get() + static_cast<std::size_t>(frame - plan_.begin) * numbers_of_shape();
    }

    /// @param threads called for each frame: how many it may use.
    template <typename Threads>
    void solve_run(std::size_t number, const Threads& threads) {
        const Run& run = plan_.runs[number];
        Frames frames;
        Execution of_run(&execution_);
        {
            std::optional<Deformer::Drag> drag;
            drag.emplace(deformer_);
            Positions shape(0, 3);  // empty until a frame could be solved
            if (run.lead >= 0) solve_frame(drag, run.lead, false, threads(), of_run, shape);
            for (Index frame = run.begin; frame < run.end; ++frame) {
                const bool in_result = frame >= run.own_begin && frame < run.own_end && plan_.is_wanted(frame);
                frames.outside.emplace_back(in_result ? nullptr : new float[numbers_of_shape()]);
                frames.shapes.push_back(in_result ? shape_in_result(frame) : frames.outside.back().get());
                const bool is_solved = solve_frame(drag, frame, in_result, threads(), of_run, shape);
                frames.is_solved.push_back(static_cast<char>(is_solved));
                const Positions& known = shape.rows() > 0 ? shape : deformer_.bound().rest();
                std::transform(known.data(), known.data() + known.size(), frames.shapes.back(),
                               [](double x) { return static_cast<float>(x); });
                ++frames_solved_;
                const double share = static_cast<double>(frames_solved_) / static_cast<double>(frames_to_solve_);
                const auto [from, to] = options_.progress;
                execution_.set_progress(from + share * (to - from));
            }
        }
        smooth(run, frames);
        keep_overlap(run, frames, overlaps_[number]);
    }

    /// @param shape of the last frame that could be solved, or empty; receives this one's. @return whether it could.
    bool solve_frame(std::optional<Deformer::Drag>& drag, Index frame, bool in_result, int threads,
                     Execution& execution, Positions& shape) {
        SolveOptions options;
        options.tolerance = options_.tolerance;
        options.max_iterations = options_.max_iterations;
        options.is_kept = true;
        options.weights = weights_at(trajectories_, frame);
        options.threads = threads;
        const auto fail = [&](const std::exception& error) {
            if (!in_result) return false;
            const std::lock_guard<std::mutex> lock(mutex_);
            result_.failures.push_back({frame, error.what()});
            return false;
        };
        try {
            Solution solution = drag->solve(targets_at(trajectories_, frame), options, execution);
            try {
                require_single_precision(solution.vertices, "the solved shape");
            } catch (const InvalidInput&) {  // the next frame begins at the last good one
                drag.emplace(deformer_, shape.rows() > 0 ? std::optional<PositionsView>(shape) : std::nullopt);
                throw;
            }
            shape = std::move(solution.vertices);
            if (!in_result) return true;
            const auto row = static_cast<std::size_t>(frame - plan_.begin);
            result_.energies[row] = solution.energy;
            energies_[row] = solution.part_energies;
            result_.iterations[row] = solution.all_iterations;
            result_.converged[row] = static_cast<char>(solution.converged);
            return true;
        } catch (const InvalidInput& error) {
            return fail(error);
        } catch (const SolverFailure& error) {
            return fail(error);
        }
    }

    /// Spreads the snaps of a run. Frames that could not be solved hold what becomes of the one before.
    void smooth(const Run& run, Frames& frames) {
        const auto count = static_cast<Index>(frames.shapes.size());
        std::vector<char> stays(frames.is_solved.size(), 0);
        stays.front() = stays.back() = 1;
        for (Index k = 0; k < count; ++k) {
            const bool is_kept = std::binary_search(options_.kept.begin(), options_.kept.end(), run.begin + k);
            if (is_kept || !frames.is_solved[k]) stays[k] = 1;
            if (k > 0 && !frames.is_solved[k]) stays[k - 1] = 1;
        }
        const double least_told = kTold * bounding_box_diagonal(deformer_.bound().rest());
        for (std::size_t number = 0; number < parts_.size(); ++number) {
            const double size = bounding_box_diagonal(parts_[number].shape->region.positions);
            if (size == 0.0) continue;  // a point is where it is pulled
            RunPaths paths(frames.shapes, parts_[number].vertices(), frames.is_solved);
            const std::vector<double> limits = paths.limits(trajectories_, parts_[number].anchors, run.begin, size);
            const std::vector<Snap> snaps = paths.find_snaps(limits, execution_);
            const std::vector<char> is_moved = paths.spread(snaps, limits, stays, plan_.overlap, execution_);
            for (Index frame = std::max(plan_.begin, run.own_begin); frame < std::min(plan_.end, run.end); ++frame)
                is_moved_[frame - plan_.begin][number] = is_moved[frame - run.begin];
            const std::lock_guard<std::mutex> lock(mutex_);
            for (const Snap& snap : snaps) {
                const Index frame = run.begin + snap.frame;
                if (snap.length >= least_told && frame >= run.own_begin && plan_.is_wanted(frame))
                    result_.snaps.push_back(frame);
            }
        }
    }

    /// Lets what was moved of a frame go back towards its minimum: a blend of two shapes is none of the surface's
    /// own.
    void settle(std::size_t row, int threads) {
        const Index frame = plan_.begin + static_cast<Index>(row);
        if (std::isnan(result_.energies[row])) return;  // it holds another frame's
        const std::vector<char>& is_moved = is_moved_[row];
        if (std::find(is_moved.begin(), is_moved.end(), char{1}) == is_moved.end()) return;
        SolveOptions options;
        options.tolerance = options_.tolerance;
        options.max_iterations = std::min(options_.max_iterations, kMostSettling);
        for (std::size_t part = 0; part < parts_.size(); ++part)
            options.enough_energies.push_back(is_moved[part] ? kMostEnergy * energies_[row][part] : kWhatever);
        options.weights = weights_at(trajectories_, frame);
        options.threads = threads;
        float* const shape = shape_in_result(frame);
        const Positions start =
            Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(shape, result_.vertex_count, 3)
                .cast<double>();
        Execution of_frame(&execution_);
        try {
            const Positions settled =
                deformer_.solve(targets_at(trajectories_, frame), start, options, of_frame).vertices;
            require_single_precision(settled, "the solved shape");
            for (std::size_t part = 0; part < parts_.size(); ++part) {
                if (!is_moved[part]) continue;
                for (const Index v : parts_[part].vertices())
                    Eigen::Map<Eigen::RowVector3f>(shape + std::size_t{3} * v) = settled.row(v).cast<float>();
            }
        } catch (const InvalidInput&) {  // what was spread is as good as it gets
        } catch (const SolverFailure&) {
        }
    }

    /// @param overlap receives the wanted shapes that the run before fades into: one for each frame of the overlap,
    /// none where a frame is not wanted or could not be solved.
    void keep_overlap(const Run& run, Frames& frames, std::vector<Shape>& overlap) const {
        for (Index frame = run.own_begin - plan_.overlap; frame < run.own_begin; ++frame) {
            const Index place = frame - run.begin;
            const bool is_there = plan_.is_wanted(frame) && frame < run.end && frames.is_solved[place];
            overlap.push_back(is_there ? std::move(frames.outside[place]) : nullptr);
        }
    }

    /// Fades the run before into this one.
    void fade_into(std::size_t number) {
        for (std::size_t k = 0; k < overlaps_[number].size(); ++k) {
            const Shape& to = overlaps_[number][k];
            if (!to) continue;
            execution_.check();
            const auto place = static_cast<Index>(k);
            const auto share = static_cast<float>(fade(place, plan_.overlap));
            const Index frame = plan_.runs[number].own_begin - plan_.overlap + place;
            float* const from = shape_in_result(frame);
            is_moved_[frame - plan_.begin].assign(parts_.size(), 1);
            for (std::size_t i = 0; i < numbers_of_shape(); ++i)
                from[i] += share * (to[i] - from[i]);
        }
    }

    /// Where paths were smoothed or faded, loose parts go with what carries them now.
    void carry_loose_parts(int threads) {
        const BoundMesh& bound = deformer_.bound();
        if (bound.loose_parts().carriers().empty()) return;
        for (Index frame = plan_.begin; frame < plan_.end; ++frame)
            bound.loose_parts().carry(bound.rest(), shape_in_result(frame), threads, execution_);
    }

    const Deformer& deformer_;
    const Trajectories& trajectories_;
    const SequenceOptions& options_;
    Execution& execution_;
    RunPlan plan_;
    const std::vector<BoundPart>& parts_;
    std::vector<std::vector<Shape>> overlaps_;  // of each run
    std::int64_t frames_to_solve_ = 0;
    std::atomic<std::int64_t> frames_solved_{0};
    std::mutex mutex_;                           // of result_.failures and snaps
    std::vector<std::vector<double>> energies_;  // of each wanted frame: Solution::part_energies
    std::vector<std::vector<char>> is_moved_;    // of each wanted frame and part: not where it was solved
    Sequence result_;
};

}  // namespace

Sequence solve_sequence(const Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                        Execution& execution) {
    return SequenceSolve(deformer, trajectories, options, execution).run();
}

}  // namespace meanvalue
