#include "meanvalue/baselines/laplacian.h"

namespace meanvalue::baselines {
namespace {

/// setup.start, with the free vertices where the Laplacian coordinates of `shape` are kept best.
Positions keep_laplacian(const Setup& setup, const PositionsView& shape, Execution& execution) {
    const LinearRows<1> rows = uniform_laplacian(setup, execution);
    Positions positions = setup.start;
    SparseCholesky cholesky;
    minimise_rows(rows, rows.apply(shape, execution), setup.unknowns, cholesky, positions, execution);
    return positions;
}

}  // namespace

LinearRows<1> uniform_laplacian(const Setup& setup, const Execution& execution) {
    using Coefficient = LinearRows<1>::Coefficient;
    LinearRows<1> rows;
    for (const Index v : setup.unknowns.rows) {
        execution.check_every(rows.offsets.size());
        rows.add(v, Coefficient(1.0));
        for (const Index* j = setup.rings.begin(v); j != setup.rings.end(v); ++j)
            rows.add(*j, Coefficient(-1.0 / setup.rings.valence(v)));
        rows.end_row();
    }
    return rows;
}

Positions laplacian(const Problem& problem, Execution& execution) {
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    return keep_laplacian(setup, problem.vertices, execution);
}

Positions smooth_start(const Setup& setup, Execution& execution) {
    return keep_laplacian(setup, setup.carried, execution);
}

}  // namespace meanvalue::baselines
