// FastSolve from an earlier answer, as while dragging.
#include "meanvalue/decode/fast/fast_solve.h"

namespace meanvalue {

/// Moves the free vertices by what the initial Hessian answers to the moves of the fixed ones: the least energy of
/// all displacements, as far as it is the same in every pose. Where an anchor moves alone, its surroundings are torn
/// instead, and minimizing has to begin from a spike. @param previous where the fixed vertices were; in `positions`
/// they are where they go, and free ones where they were.
void FastSolve::respond(Level level, std::size_t stage, const Positions& previous, Positions& positions) {
    const FixedCoupling& coupling = level.bound.stages[stage].coupling;
    Positions moves(static_cast<Eigen::Index>(coupling.vertices.size()), 3);
    for (std::size_t k = 0; k < coupling.vertices.size(); ++k)
        moves.row(k) = positions.row(coupling.vertices[k]) - previous.row(coupling.vertices[k]);
    if (moves.isZero(0.0)) return;
    Positions answer = -(coupling.matrix * moves);
    preconditioner_of(level, stage).solve(answer, answer, threads_, execution_);
    const std::vector<Index>& free = level.bound.unknowns.free;
    for (std::size_t k = 0; k < free.size(); ++k)
        positions.row(free[k]) += answer.row(k);
}

/// Goes on from the last answer of a drag, as the answers before predict, or from another shape. What the fixed
/// vertices move besides is answered by the initial Hessian.
void FastSolve::start_warm(const Positions& previous, Positions& positions) {
    const FastLevel& level = whole().bound;
    Positions start = previous;
    if (goes_on_) {
        work_.predictor.predict(drivers(positions, soft_targets()), start, threads_, execution_);
    } else if (options_.in_drag) {
        work_.predictor.begin(previous, drivers(previous, soft_targets()));
    }
    for (const Index v : level.unknowns.free)
        positions.row(v) = start.row(v);
    respond(whole(), level.stages.size() - 1, start, positions);
}

/// What drives the shape: the fixed vertices next to free ones, in `positions`, then the rows of soft anchors.
Positions FastSolve::drivers(const Positions& positions, const Positions& soft) const {
    const std::vector<Index>& fixed = problem_.levels.front()->stages.back().coupling.vertices;
    Positions result(static_cast<Eigen::Index>(fixed.size()) + soft.rows(), 3);
    for (std::size_t k = 0; k < fixed.size(); ++k)
        result.row(k) = positions.row(fixed[k]);
    result.bottomRows(soft.rows()) = soft;
    return result;
}

}  // namespace meanvalue
