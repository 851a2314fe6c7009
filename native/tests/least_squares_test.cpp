#include "meanvalue/baselines/least_squares.h"

#include <Eigen/QR>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using baselines::LinearRows;

/// Four vertices, of which 1 and 3 are free; three rows.
Unknowns two_free_of_four() {
    return {{1, 3}, {-1, 0, -1, 1}, {0, 1, 3}};
}

LinearRows<3> random_rows() {
    LinearRows<3> rows;
    for (int row = 0; row < 3; ++row) {
        for (Index v = 0; v < 4; ++v)
            rows.add(v, Matrix3::Random());
        rows.end_row();
    }
    return rows;
}

TEST(LeastSquares, FindsWhatADenseSolverFindsAndMovesOnlyTheFree) {
    std::srand(1);
    const LinearRows<3> rows = random_rows();
    const Positions wanted = Positions::Random(3, 3);
    const Positions start = Positions::Random(4, 3);
    Positions positions = start;
    SparseCholesky cholesky;
    Execution execution;
    minimise_rows(rows, wanted, two_free_of_four(), cholesky, positions, execution);
    EXPECT_EQ(positions.row(0), start.row(0));
    EXPECT_EQ(positions.row(2), start.row(2));

    Eigen::Matrix<double, 9, 6> dense;
    for (int row = 0; row < 3; ++row) {
        dense.block<3, 3>(3 * row, 0) = rows.coefficients[4 * row + 1];
        dense.block<3, 3>(3 * row, 3) = rows.coefficients[4 * row + 3];
    }
    const Positions residual = wanted - rows.apply(start, Execution());
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> right_hand_side(residual.data());
    const Eigen::Matrix<double, 6, 1> moves = dense.colPivHouseholderQr().solve(right_hand_side);
    EXPECT_LT((positions.row(1) - start.row(1) - moves.head<3>().transpose()).norm(), 1e-10);
    EXPECT_LT((positions.row(3) - start.row(3) - moves.tail<3>().transpose()).norm(), 1e-10);
}

TEST(LeastSquares, WhatTheRowsLeaveOpenStaysWhereItIs) {
    // Only the difference of the two free vertices is asked for: their mean stays.
    LinearRows<1> rows;
    rows.add(1, LinearRows<1>::Coefficient(1.0));
    rows.add(3, LinearRows<1>::Coefficient(-1.0));
    rows.end_row();
    Positions positions = Positions::Zero(4, 3);
    positions.row(1) << 1, 2, 3;
    SparseCholesky cholesky;
    Execution execution;
    minimise_rows(rows, Positions::Constant(1, 3, 4.0), two_free_of_four(), cholesky, positions, execution);
    EXPECT_LT((positions.row(1) - Eigen::RowVector3d(2.5, 3.0, 3.5)).norm(), 1e-9);
    EXPECT_LT((positions.row(3) - Eigen::RowVector3d(-1.5, -1.0, -0.5)).norm(), 1e-9);
}

TEST(LeastSquares, ACoefficientAddedTwiceCountsTwice) {
    LinearRows<1> rows;
    rows.add(1, LinearRows<1>::Coefficient(0.5));
    rows.add(1, LinearRows<1>::Coefficient(0.5));
    rows.add(3, LinearRows<1>::Coefficient(0.0));
    rows.end_row();
    Positions positions = Positions::Zero(4, 3);
    SparseCholesky cholesky;
    Execution execution;
    minimise_rows(rows, Positions::Constant(1, 3, 4.0), two_free_of_four(), cholesky, positions, execution);
    EXPECT_LT((positions.row(1).array() - 4.0).abs().maxCoeff(), 1e-9);
}

TEST(LeastSquares, RefusesRowsThatAreTooLong) {
    constexpr Index kCount = 10000;
    LinearRows<3> rows;
    Unknowns unknowns;
    for (Index v = 0; v < kCount; ++v) {
        rows.add(v, Matrix3::Identity());
        unknowns.free.push_back(v);
        unknowns.slot.push_back(v);
    }
    rows.end_row();
    unknowns.rows = {0};
    Positions positions = Positions::Zero(kCount, 3);
    SparseCholesky cholesky;
    Execution execution;
    const std::string refusal = message_of<InvalidInput>(
        [&] { minimise_rows(rows, Positions::Zero(1, 3), unknowns, cholesky, positions, execution); });
    EXPECT_TRUE(contains(refusal, "vertex 0 has 9999 neighbours that may move, and at most 2048"));
}

TEST(SparseCholesky, SolvesSeveralRightHandSidesAsItSolvesOne) {
    SparseMatrix lower(3, 3);
    lower.insert(0, 0) = 4.0;
    lower.insert(1, 0) = 1.0;
    lower.insert(1, 1) = 3.0;
    lower.insert(2, 2) = 2.0;
    lower.makeCompressed();
    SparseCholesky cholesky;
    Execution execution;
    cholesky.analyse(lower, execution);
    ASSERT_TRUE(cholesky.factorise(lower, execution));
    const Eigen::MatrixXd sides = Eigen::MatrixXd::Random(3, 2);
    const Eigen::MatrixXd solved = cholesky.solve(sides, execution);
    for (Eigen::Index k = 0; k < 2; ++k)
        EXPECT_LT((cholesky.solve(Eigen::VectorXd(sides.col(k)), execution) - solved.col(k)).norm(), 1e-14);
}

}  // namespace
}  // namespace meanvalue::tests
