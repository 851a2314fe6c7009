// One call of solve_sequence().
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "meanvalue/sequence/run.h"
#include "meanvalue/sequence/run_plan.h"
#include "meanvalue/sequence/seam.h"
#include "meanvalue/sequence/sequence.h"

namespace meanvalue {

/// Solves runs side by side, each from rest, smooths them and lets each fade into the next.
class SequenceSolve {
  public:
    /// @pre all outlive it. @throws InvalidInput, Cancelled.
    SequenceSolve(const Deformer& deformer, const Trajectories& trajectories, const SequenceOptions& options,
                  Execution& execution);

    /// As solve_sequence(); once.
    Sequence run();

  private:
    bool is_told_by(const Run& run, Index frame) const;

    template <typename Threads>
    void solve_run(Run& run, const Threads& threads);
    bool solve_frame(std::optional<Deformer::Drag>& drag, Index frame, bool is_told, int threads,
                     Execution& execution, Positions& shape);
    float* add_frame(Run& run, bool in_result);
    void smooth(Run& run);
    void carry_loose_parts(int threads);
    void report_progress();

    std::size_t numbers_of_shape() const { return static_cast<std::size_t>(result_.vertex_count) * 3; }
    float* row(Index frame) {
        return result_.vertices.get() + static_cast<std::size_t>(frame - plan_.begin()) * numbers_of_shape();
    }
    const Positions& shape_or_rest(const Positions& shape) const {
        return shape.rows() > 0 ? shape : deformer_.bound().rest();
    }

    const Deformer& deformer_;
    const Trajectories& trajectories_;
    const SequenceOptions& options_;
    Execution& execution_;
    RunPlan plan_;
    double unseen_ = 0.0;
    std::vector<std::unique_ptr<Seam>> seams_;  // before the first run, and behind each
    std::deque<Run> runs_;
    std::atomic<std::int64_t> frames_solved_{0};
    std::mutex mutex_;  // of result_.failures
    Sequence result_;
};

}  // namespace meanvalue
