#include "reference/least_squares.h"

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/optimise/ring_limit.h"

namespace meanvalue::baselines {
namespace {

// On the diagonal of the normal matrix, as a share of its largest entry: keeps it factorable where a part has too few
// fixed points. Along the directions left open the right-hand side is zero, so that nothing moves along them.
constexpr double kLeastDiagonal = 1e-12;
// Each pass takes the error that kLeastDiagonal and rounding make down by several orders of magnitude.
constexpr int kPasses = 4;

}  // namespace

void require_short_rings(const Setup& setup) {
    std::vector<Index> neighbours;
    neighbours.reserve(setup.unknowns.rows.size());
    for (const Index v : setup.unknowns.rows) {
        neighbours.push_back(static_cast<Index>(std::count_if(
            setup.rings.begin(v), setup.rings.end(v), [&](Index j) { return setup.unknowns.number[j] >= 0; })));
    }
    meanvalue::require_short_rings(setup.unknowns.rows, neighbours);
}

void minimise_rows(const Rows& rows, const Eigen::MatrixXd& wanted, const std::vector<Index>& free,
                   SparseCholesky& cholesky, Eigen::MatrixXd& values, const Execution& execution) {
    if (free.empty()) return;
    const auto free_count = static_cast<Eigen::Index>(free.size());
    SparseMatrix selection(rows.cols(), free_count);
    selection.reserve(Eigen::VectorXi::Ones(free_count));
    for (Eigen::Index k = 0; k < free_count; ++k)
        selection.insert(free[k], k) = 1.0;
    const SparseMatrix columns = rows * selection;
    execution.check();
    SparseMatrix normal = SparseMatrix(columns.transpose()) * columns;
    execution.check();
    normal.diagonal().array() += kLeastDiagonal * normal.diagonal().maxCoeff();
    const SparseMatrix lower = normal.triangularView<Eigen::Lower>();
    if (!cholesky.analysed()) cholesky.analyse(lower, execution);
    if (!cholesky.factorise(lower, execution)) {
        throw SolverFailure(message("the linear system of ", free_count, " unknowns is not positive definite"));
    }
    for (int pass = 0; pass < kPasses; ++pass) {
        const Eigen::MatrixXd moves = cholesky.solve(columns.transpose() * (wanted - rows * values), execution);
        if (!moves.allFinite()) {
            throw SolverFailure(message("the linear system of ", free_count, " unknowns has no finite solution"));
        }
        values += selection * moves;
    }
}

}  // namespace meanvalue::baselines
