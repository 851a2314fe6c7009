// One solve by method `fast`: from rest coarse to fine, or onwards from an earlier answer; by L-BFGS.
#pragma once

#include <vector>

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/fast_problem.h"

namespace meanvalue {

/// A cold start, from rest: on the coarsest level, stiff first and then less and less, and along the handles' screws
/// where they rotate far, whichever ends lower; from there to finer levels. A warm start, from an earlier answer as
/// while dragging: what the last answers predict, or before there are any the coarsest level; and the initial
/// Hessian's answer to what the drivers have moved besides. Then the whole mesh is minimized to the tolerance.
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

    Level level(std::size_t number) const { return {*problem_.levels[number], work_.levels[number]}; }
    Level whole() const { return level(0); }
    Level coarsest() const { return level(problem_.levels.size() - 1); }

    LbfgsOptions lbfgs_options(int max_iterations, double least_tolerance = 0.0) const;
    LbfgsReport minimise(Level level, std::size_t stage, LbfgsOptions options, Positions& positions);
    Preconditioner preconditioner_of(Level level, std::size_t stage);
    double energy_of(Level level, const Positions& positions);
    /// What anchors count in this solve, and where they are pulled.
    void set_soft_targets();
    bool is_free(std::size_t soft_anchor) const {
        return options_.weights != nullptr && (*options_.weights)[problem_.soft[soft_anchor].anchor] == 0.0;
    }
    void pull_free_anchors_to(const Positions& positions);
    /// Those of the whole mesh.
    const Positions& soft_targets() const { return work_.levels.front().energy.soft_targets; }
    void place_along(const HandlePaths::Path& path, double fraction, Level level, Positions& positions);

    // With examples.
    bool has_examples() const { return problem_.levels.front()->examples != nullptr; }
    void forget_examples();
    double fit_examples(Level level, const Positions& shape);
    void blend_examples(Level level);
    void relax_with_examples(Level level, int most_rounds, Positions& positions);

    // From rest.
    void start_cold(Positions& from_rest, Positions& positions);
    std::vector<double> carrying_weights() const;
    void start_from_rest(Positions& positions);
    double relax(Level level, Positions& positions);
    double minimise_along(const HandlePaths::Path& path, Positions& positions);

    // From an earlier answer.
    bool leads_where_rest_does(const Positions& goal, Positions& from_rest);
    void begin_at_rest_if_free();
    void start_warm(const Positions& previous, Positions& positions);
    void begin_drag(const Positions& previous);
    void suppose_coarse_change(const Positions& moves, const Positions& previous, const Positions& goal);
    void ask_for_responses(const Positions& moves);
    double least_move() const;
    void respond(Level level, std::size_t stage, const Positions& moves, Positions& positions);
    Positions hessian_answer(Level level, std::size_t stage, const Positions& moves);
    bool history_is_exact() const;

    const FastProblem& problem_;
    FastWorkspace& work_;
    DecodeOptions options_;
    Execution& execution_;
    int threads_;
    Timings timings_;
    int all_iterations_ = 0;
    bool goes_on_ = false;  // it begins at the last answer of its drag
};

}  // namespace meanvalue
