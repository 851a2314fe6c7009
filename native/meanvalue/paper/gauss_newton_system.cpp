#include "meanvalue/paper/gauss_newton_system.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <vector>

#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue {
namespace {

// Columns of a product between two checks for cancellation: some ten milliseconds.
constexpr Eigen::Index kColumnsPerCheck = 8192;

/// The derivatives of all residuals by all free vertices.
class Jacobian {
  public:
    explicit Jacobian(const Unknowns& unknowns) : unknowns_(unknowns) {}

    /// Of a fixed vertex: nothing.
    void add(std::size_t row, Index vertex, const Matrix3& block) {
        if (unknowns_.number[vertex] < 0) return;
        for (Index r = 0; r < 3; ++r) {
            for (Index c = 0; c < 3; ++c)
                entries_.emplace_back(3 * static_cast<Index>(row) + r, 3 * unknowns_.number[vertex] + c, block(r, c));
        }
    }

    SparseMatrix matrix() const {
        SparseMatrix result(3 * static_cast<Eigen::Index>(unknowns_.rows.size()),
                            3 * static_cast<Eigen::Index>(unknowns_.free.size()));
        result.setFromTriplets(entries_.begin(), entries_.end());
        return result;
    }

  private:
    const Unknowns& unknowns_;
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries_;
};

/// The lower triangle of A^T A.
SparseMatrix normal_matrix(const SparseMatrix& jacobian, const Execution& execution) {
    const SparseMatrix transposed = jacobian.transpose();
    SparseMatrix result(jacobian.cols(), jacobian.cols());
    for (Eigen::Index begin = 0; begin < jacobian.cols(); begin += kColumnsPerCheck) {
        execution.check();
        const Eigen::Index count = std::min(kColumnsPerCheck, jacobian.cols() - begin);
        result.middleCols(begin, count) = SparseMatrix(transposed * jacobian.middleCols(begin, count));
    }
    return result.triangularView<Eigen::Lower>();
}

/// Whether a vertex without a row of its own can move in some direction in which no other row changes.
bool is_singular(const Matrix3& diagonal) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(diagonal, Eigen::EigenvaluesOnly);
    return !(solver.eigenvalues()(0) > kNegligible * diagonal.trace());
}

}  // namespace

GaussNewtonSystem linearise(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& positions,
                            const Execution& execution) {
    Jacobian jacobian(unknowns);
    Eigen::VectorXd residuals(3 * static_cast<Eigen::Index>(unknowns.rows.size()));
    std::vector<Matrix3> blocks;
    for (std::size_t row = 0; row < unknowns.rows.size(); ++row) {
        execution.check_every(row);
        const Index i = unknowns.rows[row];
        const EncodedRing ring = encoding.ring_of(i);
        blocks.resize(ring.valence);
        residuals.segment<3>(3 * static_cast<Eigen::Index>(row)) =
            Vector3(positions.row(i)) - predict_with_jacobian(ring, positions, blocks.data());
        jacobian.add(row, i, Matrix3::Identity());
        for (Index k = 0; k < ring.valence; ++k)
            jacobian.add(row, ring.ring[k], -blocks[k]);
    }
    const SparseMatrix matrix = jacobian.matrix();
    return {normal_matrix(matrix, execution), matrix.transpose() * residuals};
}

SparseMatrix smoothness_metric(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution) {
    Jacobian jacobian(unknowns);
    for (std::size_t row = 0; row < unknowns.rows.size(); ++row) {
        const Index i = unknowns.rows[row];
        const EncodedRing ring = encoding.ring_of(i);
        jacobian.add(row, i, Matrix3::Identity());
        for (Index k = 0; k < ring.valence; ++k)
            jacobian.add(row, ring.ring[k], -ring.weights[k] * Matrix3::Identity());
    }
    return normal_matrix(jacobian.matrix(), execution);
}

double energy(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& positions, int threads,
              const Execution& execution) {
    std::vector<double> squares(unknowns.rows.size());
    parallel_for(static_cast<Index>(squares.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index row = unknowns.rows[k];
            squares[k] = (Vector3(positions.row(row)) - predict(encoding.ring_of(row), positions)).squaredNorm();
        }
    });
    return 0.5 * std::accumulate(squares.begin(), squares.end(), 0.0);
}

void relax(const Encoding& encoding, const Unknowns& unknowns, int sweeps, Positions& positions,
           const Execution& execution) {
    const Grouped<Use> uses = uses_of(encoding, unknowns, execution);
    std::vector<Matrix3> blocks;
    for (std::size_t step = 0; step < sweeps * unknowns.free.size(); ++step) {
        execution.check_every(step);
        const Index vertex = unknowns.free[step % unknowns.free.size()];
        Vector3 gradient = Vector3::Zero();
        Matrix3 diagonal = Matrix3::Zero();
        if (encoding.predictable(vertex)) {
            gradient = Vector3(positions.row(vertex)) - predict(encoding.ring_of(vertex), positions);
            diagonal.setIdentity();
        }
        for (const Use& use : uses.of(vertex)) {
            const Index row = unknowns.rows[use.row];
            const EncodedRing ring = encoding.ring_of(row);
            blocks.resize(ring.valence);
            const Vector3 predicted = predict_with_jacobian(ring, positions, blocks.data());
            const Matrix3& block = blocks[use.place];
            gradient -= block.transpose() * (Vector3(positions.row(row)) - predicted);
            diagonal += block.transpose() * block;
        }
        if (!encoding.predictable(vertex) && is_singular(diagonal)) continue;
        const Vector3 move = diagonal.inverse() * gradient;
        if (move.allFinite()) positions.row(vertex) -= move;
    }
}

}  // namespace meanvalue
