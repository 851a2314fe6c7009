// One solve by the fast method.
#pragma once

#include <limits>
#include <vector>

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/fast_problem.h"
#include "meanvalue/decode/fast/fast_workspace.h"

namespace meanvalue {

/// From rest: on a coarse level, stiff first and then less and less, and along the handles' screws where they turn
/// far, whichever ends lower; then splits; then the whole mesh, to the tolerance; in between a level of a fifth,
/// where the mesh is large. From a start, as while dragging: what the last answers tell, or the constant matrix'
/// answer to what the fixed vertices have moved since, in several steps where that is far; then the whole mesh to the
/// tolerance, or where that takes many steps, from rest after all if that is lower.
class FastSolve {
  public:
    /// @pre all outlive it.
    FastSolve(const FastProblem& problem, FastWorkspace& workspace, const DecodeOptions& options, int threads,
              Execution& execution)
        : problem_(problem), work_(workspace), options_(options), execution_(execution), threads_(threads) {}

    /// See Decoder::decode().
    DecodeReport run(Positions& positions);

  private:
    /// A level with what a solve on it writes.
    struct Level {
        const FastLevel& bound;
        FastWorkspace::OfLevel& work;
    };
    /// When a minimiser ends, besides by short steps: see LbfgsOptions.
    struct StopRule {
        double energy_tolerance = 0.0;
        int patience = 0;
    };

    Level level(std::size_t number) const { return {*problem_.levels[number], work_.levels[number]}; }
    Level whole() const { return level(0); }
    Level coarsest() const { return level(problem_.levels.size() - 1); }
    StopRule cold_rule() const;
    StopRule drag_rule() const;

    LbfgsOptions lbfgs_options(double tolerance, int max_iterations, const StopRule& rule) const;
    LbfgsReport minimise(Level level, std::size_t stage, LbfgsOptions options, Positions& positions);
    Preconditioner preconditioner_of(Level level, std::size_t stage);
    double energy_of(Level level, const Positions& positions);
    /// What anchors count in this solve, and where they are pulled.
    void set_soft_targets();
    bool is_free(std::size_t soft_anchor) const {
        return !work_.levels.front().energy.soft_weights.empty() &&
               work_.levels.front().energy.soft_weights[soft_anchor] == 0.0;
    }
    void pull_free_anchors_to(const Positions& positions);
    /// Puts the soft anchors of the whole mesh to where they are pulled.
    void put_targets(Positions& positions) const;
    void place_along(const HandlePaths::Path& path, double fraction, Level level, Positions& positions);

    // From rest.
    void start_cold(Positions& positions);
    std::vector<double> hold_of_anchors() const;
    void start_from_rest(Positions& positions);
    double relax(Level level, Positions& positions);
    double relax_stage_by_stage(Positions& positions);
    double follow(const HandlePaths::Path& path, Positions& positions);
    void start_afresh_if_lower(double energy, Positions& positions);

    // From an earlier answer.
    void follow_drag(const Positions& previous, Positions& positions);
    void follow_from(const Positions& previous, Positions& positions);
    void follow_otherwise(const Positions& previous, double energy, Positions& positions);
    void respond(Level level, std::size_t stage, const Positions& previous, Positions& positions);
    void put_balanced_targets(const Positions& previous, Positions& positions);
    bool history_is_exact() const;
    Positions drivers_in(const Positions& positions) const;
    Positions drivers_of(const Positions& positions) const;

    const FastProblem& problem_;
    FastWorkspace& work_;
    const DecodeOptions& options_;
    Execution& execution_;
    int threads_;
    Timings timings_;
    double highest_start_ = std::numeric_limits<double>::infinity();  // of the whole mesh: see LbfgsOptions
    int all_iterations_ = 0;
    bool goes_on_ = false;           // it begins at the last answer of its drag
    Positions former_soft_targets_;  // then: of the solve before
};

}  // namespace meanvalue
