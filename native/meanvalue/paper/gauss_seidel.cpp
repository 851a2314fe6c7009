#include "meanvalue/paper/gauss_seidel.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue {
namespace {

/// Whether a vertex without a row of its own can move in some direction in which no other row changes.
bool is_singular(const Matrix3& diagonal) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(diagonal, Eigen::EigenvaluesOnly);
    return !(solver.eigenvalues()(0) > kNegligible * diagonal.trace());
}

}  // namespace

GaussSeidel::GaussSeidel(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution)
    : encoding_(encoding), unknowns_(unknowns) {
    WorkMeter work(execution);
    uses_ = grouped<Use>(unknowns.free.size(), [&](const auto& visit) {
        for (const Index row : unknowns_.rows) {
            work.add(1 + encoding_.ring_offsets[row + 1] - encoding_.ring_offsets[row]);
            for (Index k = encoding_.ring_offsets[row]; k < encoding_.ring_offsets[row + 1]; ++k) {
                const Index number = unknowns_.number[encoding_.ring[k]];
                if (number >= 0) visit(number, Use{row, k - encoding_.ring_offsets[row]});
            }
        }
    });
}

void GaussSeidel::sweep(Positions& positions, const Execution& execution) const {
    for (std::size_t number = 0; number < unknowns_.free.size(); ++number) {
        execution.check_every(number);
        relax(static_cast<Index>(number), positions);
    }
}

void GaussSeidel::relax(Index number, Positions& positions) const {
    const Index vertex = unknowns_.free[number];
    Vector3 gradient = Vector3::Zero();
    Matrix3 diagonal = Matrix3::Zero();
    if (encoding_.predictable(vertex)) {
        gradient = Vector3(positions.row(vertex)) - predict(encoding_.ring_of(vertex), positions);
        diagonal.setIdentity();
    }
    for (const Use& use : uses_.of(number)) {
        Matrix3 block;
        const Vector3 predicted = predict_with_jacobian_of(encoding_.ring_of(use.row), positions, use.place, block);
        gradient -= block.transpose() * (Vector3(positions.row(use.row)) - predicted);
        diagonal += block.transpose() * block;
    }
    if (!encoding_.predictable(vertex) && is_singular(diagonal)) return;
    const Vector3 move = diagonal.inverse() * gradient;
    if (move.allFinite()) positions.row(vertex) -= move;
}

}  // namespace meanvalue
