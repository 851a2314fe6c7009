#include "meanvalue/baselines/least_squares.h"

#include "meanvalue/common/errors.h"
#include "meanvalue/linalg/block_matrix.h"
#include "meanvalue/linalg/product_pattern.h"
#include "meanvalue/optimise/ring_room.h"

namespace meanvalue::baselines {
namespace {

// On the diagonal of the normal matrix, as a share of its largest entry: keeps it factorable where a part has too few
// fixed points. Along the directions left open the right-hand side is zero, so that nothing moves along them.
constexpr double kLeastDiagonal = 1e-12;
// Each pass takes the error that kLeastDiagonal and rounding make down by several orders of magnitude.
constexpr int kPasses = 4;

/// v_j as the coefficients see it: a line of three coordinates for a number, a column for a 3 x 3 matrix.
template <int Size>
using Point = Eigen::Matrix<double, Size, 3 / Size, Size == 1 ? Eigen::RowMajor : Eigen::ColMajor>;

template <int Size>
Eigen::Map<const Point<Size>> point(const PositionsView& positions, Eigen::Index row) {
    return Eigen::Map<const Point<Size>>(positions.row(row).data());
}

template <int Size>
Eigen::Map<Point<Size>> point(Positions& positions, Eigen::Index row) {
    return Eigen::Map<Point<Size>>(positions.row(row).data());
}

/// The lower triangle of A^T A over the free vertices, with kLeastDiagonal on its diagonal.
template <int Size>
SymmetricBlocks<Size> normal_matrix(const LinearRows<Size>& rows, const Unknowns& unknowns,
                                    const Execution& execution) {
    std::vector<std::int64_t> offsets = {0};
    std::vector<Index> columns;
    std::vector<std::int64_t> terms;  // of `rows`
    RingRoom room(Size == 1 ? kNumberPairs : kBlockPairs);
    for (Eigen::Index row = 0; row < rows.row_count(); ++row) {
        execution.check_every(row);
        for (std::int64_t term = rows.offsets[row]; term < rows.offsets[row + 1]; ++term) {
            const Index slot = unknowns.slot[rows.vertices[term]];
            if (slot < 0) continue;
            columns.push_back(slot);
            terms.push_back(term);
        }
        const Index vertex = unknowns.rows[row];
        const auto found = static_cast<std::int64_t>(columns.size()) - offsets.back();
        room.add(vertex, unknowns.slot[vertex] >= 0 ? found - 1 : found);
        offsets.push_back(static_cast<std::int64_t>(columns.size()));
    }
    room.require();
    SymmetricBlocks<Size> normal(
        product_pattern(offsets, columns, static_cast<Index>(unknowns.free.size()), execution), execution);
    normal.set_zero(execution);
    WorkMeter work(execution);
    for (std::size_t row = 0; row + 1 < offsets.size(); ++row) {
        for (std::int64_t a = offsets[row]; a < offsets[row + 1]; ++a) {
            work.add(8 * (offsets[row + 1] - offsets[row]));
            for (std::int64_t b = offsets[row]; b < offsets[row + 1]; ++b) {
                if (columns[a] < columns[b]) continue;
                normal.add(normal.find(columns[a], columns[b]), columns[b],
                           rows.coefficients[terms[a]].transpose() * rows.coefficients[terms[b]]);
            }
        }
    }
    normal.add_to_diagonal(kLeastDiagonal * normal.largest_on_diagonal());
    return normal;
}

}  // namespace

template <int Size>
Positions LinearRows<Size>::apply(const PositionsView& positions, const Execution& execution) const {
    Positions values = Positions::Zero(row_count(), 3);
    for (Eigen::Index row = 0; row < row_count(); ++row) {
        execution.check_every(row);
        auto value = point<Size>(values, row);
        for (std::int64_t term = offsets[row]; term < offsets[row + 1]; ++term)
            value += coefficients[term] * point<Size>(positions, vertices[term]);
    }
    return values;
}

template <int Size>
void minimise_rows(const LinearRows<Size>& rows, const Positions& wanted, const Unknowns& unknowns,
                   SparseCholesky& cholesky, Positions& positions, Execution& execution) {
    if (unknowns.free.empty()) return;
    const SymmetricBlocks<Size> normal = normal_matrix(rows, unknowns, execution);
    const SparseMatrix& lower = normal.matrix();
    if (!cholesky.analysed()) cholesky.analyse(lower, execution);
    if (!cholesky.factorise(lower, execution)) {
        throw SolverFailure(message("the linear system of ", lower.rows(), " unknowns is not positive definite"));
    }
    const Eigen::Index free_count = static_cast<Eigen::Index>(unknowns.free.size());
    for (int pass = 0; pass < kPasses; ++pass) {
        execution.check();
        const Positions residual = wanted - rows.apply(positions, execution);
        Positions descent = Positions::Zero(free_count, 3);
        for (Eigen::Index row = 0; row < rows.row_count(); ++row) {
            execution.check_every(row);
            for (std::int64_t term = rows.offsets[row]; term < rows.offsets[row + 1]; ++term) {
                const Index slot = unknowns.slot[rows.vertices[term]];
                if (slot < 0) continue;
                point<Size>(descent, slot) += rows.coefficients[term].transpose() * point<Size>(residual, row);
            }
        }
        // As columns: three of numbers for Size 1, a single one for Size 3. Positions are stored line by line.
        using Lines = Eigen::Matrix<double, Eigen::Dynamic, 3 / Size, Size == 1 ? Eigen::RowMajor : Eigen::ColMajor>;
        const Eigen::Map<const Lines> lines(descent.data(), Size * free_count, 3 / Size);
        const Lines moves = cholesky.solve(Eigen::MatrixXd(lines), execution);
        const Eigen::Map<const Positions> free_moves(moves.data(), free_count, 3);
        if (!free_moves.allFinite()) {
            throw SolverFailure(message("the linear system of ", lower.rows(), " unknowns has no finite solution"));
        }
        for (Eigen::Index k = 0; k < free_count; ++k)
            positions.row(unknowns.free[k]) += free_moves.row(k);
    }
}

template struct LinearRows<1>;
template struct LinearRows<3>;
template void minimise_rows(const LinearRows<1>&, const Positions&, const Unknowns&, SparseCholesky&, Positions&,
                            Execution&);
template void minimise_rows(const LinearRows<3>&, const Positions&, const Unknowns&, SparseCholesky&, Positions&,
                            Execution&);

}  // namespace meanvalue::baselines
