#include "meanvalue/sequence/sequence.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <tuple>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/sequence/smooth_paths.h"

namespace meanvalue {
namespace {

// A solve from rest ends when the energy falls slowly; where it lies in a valley, solves from its answer go on.
constexpr int kSolvesFromRest = 3;
// Roughness of the paths of vertices that is left alone, as a share of the diagonal: it can't be seen.
constexpr double kUnseen = 2e-5;
// Of a coordinate in the result, which is single precision: with room for differences and what smoothing adds.
constexpr double kMostCoordinate = std::numeric_limits<float>::max() / 8.0;

using Shape = std::unique_ptr<float[]>;  // n x 3

/// Where one run fades into the next, at frame `at` of the clip. Those of the earlier are in the result.
struct Seam {
    std::int64_t at = 0;
    std::vector<Shape> after;  // of the later run's wanted frames before; none: it could not solve that frame
    std::atomic<int> sides_done{0};
};

/// The frames that a run solves, and those that it goes through on the way.
struct Run {
    Index number;
    Index begin;
    Index end;                    // of what is solved
    std::vector<float*> shapes;   // of each frame, in the result or in `aside`
    std::vector<Shape> aside;     // of each frame: none where it is in the result
    std::vector<char> is_solved;  // of each frame
};

/// 0 to 1 with no slope at either end, and the least second difference. @param frame of `count`, counted from 0.
double fade(Index frame, Index count) {
    const double t = (frame + 1.0) / (count + 1.0);
    return t < 0.5 ? 2.0 * t * t : 1.0 - 2.0 * (1.0 - t) * (1.0 - t);
}

/// @throws InvalidInput.
void require_single_precision(const Positions& shape, const char* name) {
    const double most = shape.rows() > 0 ? shape.cwiseAbs().maxCoeff() : 0.0;
    if (most <= kMostCoordinate) return;
    throw InvalidInput(message(name, " has coordinates up to ", most, ", but frames are in single precision; scale ",
                               "mesh and targets so that they stay below ", kMostCoordinate));
}

class SequenceSolve {
  public:
    SequenceSolve(Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                  Execution& execution)
        : deformer_(deformer), trajectories_(trajectories), options_(options), execution_(execution) {
        execution.check();
        check_options();
        chunk_ = std::min(options.chunk, std::max<Index>(1, trajectories.frame_count));
        overlap_ = std::min(options.overlap, chunk_);
        std::tie(begin_, end_) = options.frames.value_or(std::pair<Index, Index>{0, trajectories.frame_count});
        const Positions& rest = deformer.bound().rest();
        require_single_precision(rest, "the rest shape");
        if (rest.rows() > 0) unseen_ = kUnseen * (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm();
        result_.first = begin_;
        result_.vertex_count = deformer.report().vertex_count;
        const auto count = static_cast<std::size_t>(end_ - begin_);
        result_.frame_count = end_ - begin_;
        // Without writing to it: gigabytes take longer than a cancel may wait, and each frame is written anyway.
        result_.vertices.reset(new float[count * static_cast<std::size_t>(result_.vertex_count) * 3]);
        result_.energies.assign(count, std::numeric_limits<double>::quiet_NaN());
        result_.iterations.resize(count);
        result_.converged.resize(count);
    }

    Sequence run() {
        if (begin_ == end_) return std::move(result_);
        const Index first_run = begin_ / chunk_;
        Index last_run = (end_ - 1) / chunk_;
        if (has_seam_behind(last_run) && end_ > (last_run + 1) * chunk_ - overlap_) ++last_run;
        for (Index run = first_run; run <= last_run + 1; ++run)
            seams_.emplace_back(std::make_unique<Seam>())->at = std::int64_t{run} * chunk_;
        first_run_ = first_run;
        for (Index run = first_run; run <= last_run; ++run) {
            execution_.check();
            begins_.push_back(find_begin(run));
            frames_to_solve_ += end_to_solve(run) - begins_.back();
        }
        const int threads = thread_count(options_.threads);
        const int workers = std::min<int>(threads, last_run - first_run + 1);
        std::atomic<Index> next{first_run};
        std::atomic<int> active{workers};
        execution_.begin_stage("solve");
        run_workers(workers, [&](int) {
            try {
                for (Index run = next++; run <= last_run; run = next++)
                    solve_run(run, [&] { return std::max(1, threads / std::max(1, active.load())); });
            } catch (...) {
                next = last_run + 1;  // the others need not begin another
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

  private:
    void check_options() const {
        if (trajectories_.anchor_count != deformer_.report().anchor_count) {
            throw InvalidInput(message("targets are of ", trajectories_.anchor_count, " anchors, but the mesh has ",
                                       deformer_.report().anchor_count));
        }
        if (options_.chunk < 1) throw InvalidInput(message("chunk is ", options_.chunk, "; give 1 or more"));
        if (options_.overlap < 0) throw InvalidInput(message("overlap is ", options_.overlap, "; give 0 or more"));
        if (options_.tolerance && !(*options_.tolerance > 0.0))
            throw InvalidInput(message("tolerance is ", *options_.tolerance, "; give a positive number"));
        if (options_.max_iterations < 0)
            throw InvalidInput(message("max_iterations is ", options_.max_iterations, "; give 0 or more"));
        for (Index frame = 0; !trajectories_.weights.empty() && frame < trajectories_.frame_count; ++frame) {
            execution_.check_every(frame);
            try {
                deformer_.bound().check_weights(trajectories_.weights_at(frame));
            } catch (const InvalidInput& error) {
                throw InvalidInput(message("frame ", frame, ": ", error.what()));
            }
        }
        if (!options_.frames) return;
        const auto [begin, end] = *options_.frames;
        if (begin < 0 || end < begin || end > trajectories_.frame_count) {
            throw InvalidInput(message("frames is (", begin, ", ", end, "), but the clip has ",
                                       trajectories_.frame_count, " frames, numbered from 0"));
        }
    }

    /// So much earlier that it has a shape before it comes to frames that can't be solved; 0 where none can before.
    Index find_begin(Index run) const {
        auto frame = static_cast<Index>(std::max<std::int64_t>(0, std::int64_t{run} * chunk_ - overlap_));
        while (frame > 0 &&
               !deformer_.bound().can_be_placed(trajectories_.targets_at(frame), trajectories_.weights_at(frame)))
            --frame;
        return frame;
    }
    Index end_of(Index run) const {
        return static_cast<Index>(
            std::min<std::int64_t>(trajectories_.frame_count, (std::int64_t{run} + 1) * chunk_));
    }
    /// End of the frames that what is wanted of a run depends on: smoothing looks so far ahead.
    Index end_to_solve(Index run) const {
        return static_cast<Index>(
            std::min<std::int64_t>(end_of(run), std::int64_t{end_} + 2 * std::int64_t{overlap_}));
    }
    bool has_seam_behind(Index run) const {
        return overlap_ > 0 && (std::int64_t{run} + 1) * chunk_ < trajectories_.frame_count;
    }

    template <typename Threads>
    void solve_run(Index number, const Threads& threads) {
        Seam& seam_before = *seams_[number - first_run_];
        Seam& seam_behind = *seams_[number - first_run_ + 1];
        Run run{number, begins_[number - first_run_], end_to_solve(number), {}, {}, {}};
        Execution of_run(&execution_);
        {
            Deformer::Drag drag(deformer_, of_run);
            Positions shape;  // empty until a frame could be solved
            for (Index frame = run.begin; frame < run.end; ++frame) {
                const bool is_told = frame >= seam_before.at && is_wanted(frame);
                run.is_solved.push_back(
                    static_cast<char>(solve_frame(drag, frame, is_told, threads(), of_run, shape)));
                put(shape_or_rest(shape), add_frame(run, is_told));
                report_progress();
            }
        }
        smooth(run);
        const auto first = static_cast<Index>(std::max<std::int64_t>(begin_, seam_before.at - overlap_));
        for (Index frame = std::max(first, run.begin); frame < std::min<std::int64_t>(seam_before.at, run.end);
             ++frame)
            if (is_wanted(frame))
                seam_before.after.push_back(run.is_solved[frame - run.begin] ? std::move(run.aside[frame - run.begin])
                                                                             : nullptr);
        close(seam_before);
        close(seam_behind);
    }

    bool is_wanted(Index frame) const { return begin_ <= frame && frame < end_; }

    /// Room for the next frame of a run.
    float* add_frame(Run& run, bool in_result) {
        const std::size_t numbers = numbers_of_shape();
        const Index frame = run.begin + static_cast<Index>(run.shapes.size());
        run.aside.emplace_back(in_result ? nullptr : new float[numbers]);
        run.shapes.push_back(in_result ? row(frame) : run.aside.back().get());
        return run.shapes.back();
    }

    /// From the first frame that could be solved on, as rough as the targets are; frames that could not be solved
    /// hold what becomes of the one before.
    void smooth(Run& run) {
        const auto first = static_cast<Index>(std::find(run.is_solved.begin(), run.is_solved.end(), char{1}) -
                                              run.is_solved.begin());
        const Index half_width = std::min<Index>(overlap_, end_of(run.number) - 1 - (run.begin + first));
        if (run.begin + first >= end_ || half_width < 2) return;
        const std::vector<float*> shapes(run.shapes.begin() + first, run.shapes.end());
        const PathSmoother smoother({run.is_solved.begin() + first, run.is_solved.end()}, half_width);
        std::vector<double> limits =
            smoother.roughness_of(trajectories_, run.begin + first, deformer_.bound().anchors(), shapes);
        for (double& limit : limits)
            limit += unseen_;
        smoother.smooth(shapes, static_cast<std::size_t>(result_.vertex_count), limits, execution_);
        for (std::size_t k = 1; k < shapes.size(); ++k) {
            if (!run.is_solved[first + k]) std::copy_n(shapes[k - 1], numbers_of_shape(), shapes[k]);
        }
    }

    const Positions& shape_or_rest(const Positions& shape) const {
        return shape.rows() > 0 ? shape : deformer_.bound().rest();
    }

    /// @param shape of the last frame that could be solved, or empty; receives this one's. @return whether it could.
    bool solve_frame(Deformer::Drag& drag, Index frame, bool is_told, int threads, Execution& execution,
                     Positions& shape) {
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
            const auto solve_from = [&](const Positions& before) {
                std::optional<PositionsView> start;
                if (before.rows() > 0) start.emplace(before);
                solution = drag.solve(trajectories_.targets_at(frame), start, options, execution);
                iterations += solution.all_iterations;
            };
            solve_from(shape);
            for (int left = shape.rows() > 0 ? 0 : kSolvesFromRest - 1; left > 0; --left)
                solve_from(Positions(std::move(solution.vertices)));
            require_single_precision(solution.vertices, "the solved shape");
            shape = std::move(solution.vertices);
            if (!is_told) return true;
            const auto row = static_cast<std::size_t>(frame - begin_);
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

    /// Called by either side once its frames of the seam are there; the second does the work.
    void close(Seam& seam) {
        if (++seam.sides_done < 2) return;
        const auto first = static_cast<Index>(seam.at - overlap_);
        for (std::size_t k = 0; k < seam.after.size(); ++k) {
            if (!seam.after[k]) continue;
            const Index frame = std::max(begin_, first) + static_cast<Index>(k);
            const auto share = static_cast<float>(fade(frame - first, overlap_));
            float* const to = row(frame);
            const float* const after = seam.after[k].get();
            for (std::size_t number = 0; number < numbers_of_shape(); ++number)
                to[number] += share * (after[number] - to[number]);
        }
        seam.after.clear();
    }

    /// Where paths were smoothed or faded, as what carries them is now.
    void carry_loose_parts(int threads) {
        const BoundMesh& bound = deformer_.bound();
        if (bound.loose_parts().carriers().empty()) return;
        for (Index frame = begin_; frame < end_; ++frame)
            bound.loose_parts().carry(bound.rest(), row(frame), threads, execution_);
    }

    void report_progress() {
        const double share = static_cast<double>(++frames_solved_) / static_cast<double>(frames_to_solve_);
        execution_.set_progress(options_.progress.first +
                                share * (options_.progress.second - options_.progress.first));
    }

    std::size_t numbers_of_shape() const { return static_cast<std::size_t>(result_.vertex_count) * 3; }
    float* row(Index frame) {
        return result_.vertices.get() + static_cast<std::size_t>(frame - begin_) * numbers_of_shape();
    }
    static void put(const Positions& shape, float* to) {
        std::transform(shape.data(), shape.data() + shape.size(), to, [](double x) { return static_cast<float>(x); });
    }

    Deformer& deformer_;
    const Trajectories& trajectories_;
    const SequenceOptions& options_;
    Execution& execution_;
    Index chunk_ = 1;
    Index overlap_ = 0;
    double unseen_ = 0.0;
    Index begin_ = 0;  // of what is wanted
    Index end_ = 0;
    Index first_run_ = 0;
    std::vector<std::unique_ptr<Seam>> seams_;  // before the first run, and behind each
    std::vector<Index> begins_;                 // of each run
    std::int64_t frames_to_solve_ = 0;
    std::atomic<std::int64_t> frames_solved_{0};
    std::mutex mutex_;  // of result_.failures
    Sequence result_;
};

}  // namespace

Sequence solve_sequence(Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                        Execution& execution) {
    return SequenceSolve(deformer, trajectories, options, execution).run();
}

}  // namespace meanvalue
