#include "meanvalue/solver/sparse_cholesky.h"

#include <Eigen/CholmodSupport>
#include <algorithm>

#include "meanvalue/common/abandon.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {

struct SparseCholesky::State {
    SparseMatrix lower;  // a copy: an abandoned factorisation must not read the caller's matrix
    Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower> solver;

    // Failures are returned and reported by us; CHOLMOD would print them.
    State() { solver.cholmod().print = 0; }
};

SparseCholesky::SparseCholesky() = default;
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SparseMatrix& lower, const Execution& execution) {
    const auto state = std::make_shared<State>();
    state->lower = lower;
    run_abandonable([state] { state->solver.analyzePattern(state->lower); }, execution);
    if (state->solver.cholmod().status < 0) {
        throw SolverFailure(message("the linear system of ", lower.rows(), " unknowns with ", lower.nonZeros(),
                                    " entries could not be analysed (CHOLMOD status ", state->solver.cholmod().status,
                                    "): too little memory? Restrict the region of influence"));
    }
    state_ = state;
}

bool SparseCholesky::factorise(const SparseMatrix& lower, const Execution& execution) {
    // The state is given up until the end: on cancel, the thread left behind still writes to it.
    const std::shared_ptr<State> state = std::move(state_);
    std::copy_n(lower.valuePtr(), lower.nonZeros(), state->lower.valuePtr());
    run_abandonable([state] { state->solver.factorize(state->lower); }, execution);
    state_ = state;
    if (state->solver.cholmod().status < 0) {
        throw SolverFailure(message("the linear system of ", lower.rows(), " unknowns could not be factored ",
                                    "(CHOLMOD status ", state->solver.cholmod().status,
                                    "): too little memory? Restrict the region of influence"));
    }
    return state->solver.info() == Eigen::Success;
}

Eigen::VectorXd SparseCholesky::solve(const Eigen::VectorXd& right_hand_side) const {
    return state_->solver.solve(right_hand_side);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right_hand_sides) const {
    return state_->solver.solve(right_hand_sides);
}

}  // namespace meanvalue
