#include "reference/laplacian.h"

#include "reference/least_squares.h"

namespace meanvalue::baselines {
namespace {

/// (L V)_i = v_i - (1/m_i) sum_j v_j for each row of setup.unknowns.
Rows uniform_laplacian(const Setup& setup, const Execution& execution) {
    std::vector<RowEntry> entries;
    for (std::size_t row = 0; row < setup.unknowns.rows.size(); ++row) {
        execution.check_every(row);
        const auto line = static_cast<std::int64_t>(row);
        const Index v = setup.unknowns.rows[row];
        entries.emplace_back(line, v, 1.0);
        for (const Index* j = setup.rings.begin(v); j != setup.rings.end(v); ++j)
            entries.emplace_back(line, *j, -1.0 / setup.rings.valence(v));
    }
    execution.check();
    Rows rows(static_cast<Eigen::Index>(setup.unknowns.rows.size()), setup.start.rows());
    rows.setFromTriplets(entries.begin(), entries.end());
    return rows;
}

/// setup.start, with the free vertices where the Laplacian coordinates of `shape` are kept best.
Positions keep_laplacian(const Setup& setup, const PositionsView& shape, const Execution& execution) {
    require_short_rings(setup);
    const Rows rows = uniform_laplacian(setup, execution);
    Eigen::MatrixXd positions = setup.start;
    SparseCholesky cholesky;
    minimise_rows(rows, rows * shape, setup.unknowns.free, cholesky, positions, execution);
    return positions;
}

}  // namespace

Positions laplacian(const Problem& problem, Execution& execution) {
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    return keep_laplacian(setup, problem.vertices, execution);
}

Positions smooth_start(const Setup& setup, const Execution& execution) {
    return keep_laplacian(setup, setup.carried, execution);
}

}  // namespace meanvalue::baselines
