#include "meanvalue/sequence/sequence.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <tuple>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

/// Where one run fades into the next, at frame `at` of the clip: the last frames of the one and the same of the
/// other.
struct Seam {
    std::int64_t at = 0;
    std::vector<Positions> before;
    std::vector<Positions> after;  // empty ones: of frames that the later run could not solve
    std::atomic<int> sides_done{0};
};

/// 0 to 1 with no slope at either end. @param frame of `count`, counted from 0.
double fade(Index frame, Index count) {
    const double t = (frame + 1.0) / (count + 1.0);
    return t * t * (3.0 - 2.0 * t);
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
            frames_to_solve_ += end_of(run) - begins_.back();
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
        return static_cast<Index>(std::min<std::int64_t>(end_, (std::int64_t{run} + 1) * chunk_));
    }
    bool has_seam_behind(Index run) const {
        return overlap_ > 0 && (std::int64_t{run} + 1) * chunk_ < trajectories_.frame_count;
    }

    template <typename Threads>
    void solve_run(Index run, const Threads& threads) {
        Seam& seam_before = *seams_[run - first_run_];
        Seam& seam_behind = *seams_[run - first_run_ + 1];
        Execution of_run(&execution_);
        Deformer::Drag drag(deformer_, of_run);
        Positions shape;  // empty until a frame could be solved
        for (Index frame = begins_[run - first_run_]; frame < end_of(run); ++frame) {
            const bool is_own = frame >= seam_before.at;
            const bool is_solved = solve_frame(drag, frame, is_own, threads(), of_run, shape);
            execution_.set_progress(static_cast<double>(++frames_solved_) / static_cast<double>(frames_to_solve_));
            if (frame < begin_) continue;
            if (!is_own) {
                if (frame >= seam_before.at - overlap_) seam_before.after.push_back(is_solved ? shape : Positions());
            } else if (has_seam_behind(run) && frame >= seam_behind.at - overlap_) {
                seam_behind.before.push_back(shape_or_rest(shape));
            } else {
                put(frame, shape_or_rest(shape));
            }
        }
        close(seam_before);
        close(seam_behind);
    }

    const Positions& shape_or_rest(const Positions& shape) const {
        return shape.rows() > 0 ? shape : deformer_.bound().rest();
    }

    /// @param shape of the last frame that could be solved, or empty; receives this one's. @return whether it could.
    bool solve_frame(Deformer::Drag& drag, Index frame, bool is_own, int threads, Execution& execution,
                     Positions& shape) {
        SolveOptions options;
        options.tolerance = options_.tolerance;
        options.max_iterations = options_.max_iterations;
        options.weights = trajectories_.weights_at(frame);
        options.threads = threads;
        std::optional<PositionsView> start;
        if (shape.rows() > 0) start.emplace(shape);
        const auto fail = [&](const std::exception& error) {
            if (!is_own || frame < begin_) return false;
            const std::lock_guard<std::mutex> lock(mutex_);
            result_.failures.push_back({frame, error.what()});
            return false;
        };
        try {
            Solution solution = drag.solve(trajectories_.targets_at(frame), start, options, execution);
            start.reset();
            shape = std::move(solution.vertices);
            if (!is_own || frame < begin_) return true;
            const auto row = static_cast<std::size_t>(frame - begin_);
            result_.energies[row] = solution.energy;
            result_.iterations[row] = solution.all_iterations;
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
        for (std::size_t k = 0; k < seam.before.size(); ++k) {
            // Both sides lack the same frames, those before what is wanted, and may lack what is behind it.
            const auto first = static_cast<Index>(seam.at - overlap_);
            const Index frame = std::max(begin_, first) + static_cast<Index>(k);
            Positions& shape = seam.before[k];
            if (seam.after[k].rows() > 0) shape += fade(frame - first, overlap_) * (seam.after[k] - shape);
            put(frame, shape);
        }
        seam.before.clear();
        seam.after.clear();
    }

    void put(Index frame, const Positions& shape) {
        const auto numbers = static_cast<std::size_t>(shape.size());
        float* const to = result_.vertices.get() + static_cast<std::size_t>(frame - begin_) * numbers;
        std::transform(shape.data(), shape.data() + numbers, to, [](double x) { return static_cast<float>(x); });
    }

    Deformer& deformer_;
    const Trajectories& trajectories_;
    const SequenceOptions& options_;
    Execution& execution_;
    Index chunk_ = 1;
    Index overlap_ = 0;
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

PositionsView Trajectories::targets_at(Index frame) const {
    return Eigen::Map<const Positions>(targets.data() + static_cast<std::size_t>(frame) * anchor_count * 3,
                                       anchor_count, 3);
}

std::vector<double> Trajectories::weights_at(Index frame) const {
    if (weights.empty()) return {};
    const auto first = weights.begin() + static_cast<std::ptrdiff_t>(frame) * anchor_count;
    return {first, first + anchor_count};
}

Sequence solve_sequence(Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                        Execution& execution) {
    return SequenceSolve(deformer, trajectories, options, execution).run();
}

}  // namespace meanvalue
