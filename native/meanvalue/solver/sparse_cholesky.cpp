#include "meanvalue/solver/sparse_cholesky.h"

#include <Eigen/CholmodSupport>
#include <algorithm>

#include "meanvalue/common/abandon.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {

namespace {

/// Eigen keeps the factor to itself.
class Solver : public Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower> {
  public:
    cholmod_factor* factor() { return m_cholmodFactor; }
};

}  // namespace

struct SparseCholesky::State {
    SparseMatrix lower;  // a copy: an abandoned factorisation must not read the caller's matrix
    Solver solver;

    // Failures are returned and reported by us; CHOLMOD would print them.
    State() { solver.cholmod().print = 0; }
};

namespace {

// Entries copied between two looks at the cancel flag: some milliseconds, even where memory is touched first.
constexpr std::int64_t kEntriesPerCheck = 1 << 20;
// Back-substitutions of fewer unknowns end by themselves in time; a thread would cost more.
constexpr Eigen::Index kSmallSystem = 30000;

template <typename T>
void copy_in_pieces(const T* from, std::int64_t count, T* to, const Execution& execution) {
    for (std::int64_t begin = 0; begin < count; begin += kEntriesPerCheck) {
        execution.check();
        std::copy_n(from + begin, std::min(kEntriesPerCheck, count - begin), to + begin);
    }
}

/// The pattern alone: values come with each factorisation.
void copy_pattern(const SparseMatrix& from, SparseMatrix& to, const Execution& execution) {
    to.resize(from.rows(), from.cols());
    to.resizeNonZeros(from.nonZeros());
    copy_in_pieces(from.outerIndexPtr(), from.cols() + 1, to.outerIndexPtr(), execution);
    copy_in_pieces(from.innerIndexPtr(), from.nonZeros(), to.innerIndexPtr(), execution);
}

}  // namespace

SparseCholesky::SparseCholesky() = default;
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SparseMatrix& lower, const Execution& execution, Ordering ordering) {
    const auto state = std::make_shared<State>();
    if (ordering == Ordering::kNestedDissection) {
        state->solver.cholmod().nmethods = 1;
        state->solver.cholmod().method[0].ordering = CHOLMOD_METIS;
    }
    copy_pattern(lower, state->lower, execution);
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
    try {
        if (state->lower.nonZeros() == 0) copy_pattern(lower, state->lower, execution);
        copy_in_pieces(lower.valuePtr(), lower.nonZeros(), state->lower.valuePtr(), execution);
    } catch (const Cancelled&) {
        state_ = state;  // nothing was begun
        throw;
    }
    run_abandonable([state] { state->solver.factorize(state->lower); }, execution);
    state_ = state;
    if (state->solver.cholmod().status < 0) {
        throw SolverFailure(message("the linear system of ", lower.rows(), " unknowns could not be factored ",
                                    "(CHOLMOD status ", state->solver.cholmod().status,
                                    "): too little memory? Restrict the region of influence"));
    }
    return state->solver.info() == Eigen::Success;
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const {
    if (right_hand_sides.rows() < kSmallSystem) return state_->solver.solve(right_hand_sides);
    const auto solution = std::make_shared<Eigen::MatrixXd>(right_hand_sides);
    run_abandonable([state = state_, solution] { *solution = state->solver.solve(*solution); }, execution);
    return *solution;
}

FactorView SparseCholesky::view() const {
    const cholmod_factor& factor = *state_->solver.factor();
    const auto integers = [](const void* array) { return static_cast<const std::int64_t*>(array); };
    return {static_cast<std::int64_t>(factor.nsuper),
            integers(factor.Perm),
            integers(factor.super),
            integers(factor.pi),
            integers(factor.s),
            integers(factor.px),
            static_cast<const double*>(factor.x)};
}

void SparseCholesky::release_values() {
    // To a pattern with supernodes.
    cholmod_l_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, state_->solver.factor(), &state_->solver.cholmod());
    state_->lower = SparseMatrix();
}

}  // namespace meanvalue
