#include "reference/least_squares.h"

#include <Eigen/QR>
#include <numeric>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using baselines::minimise_rows;
using baselines::require_short_rings;
using baselines::Rows;

TEST(LeastSquares, FindsWhatADenseSolverFindsAndMovesOnlyTheFree) {
    std::srand(1);
    const Eigen::MatrixXd dense = Eigen::MatrixXd::Random(9, 6);
    const Eigen::MatrixXd wanted = Eigen::MatrixXd::Random(9, 2);
    const Eigen::MatrixXd start = Eigen::MatrixXd::Random(6, 2);
    const std::vector<Index> free = {1, 3, 4};
    Eigen::MatrixXd values = start;
    SparseCholesky cholesky;
    minimise_rows(Rows(dense.sparseView()), wanted, free, cholesky, values, Execution());
    const Eigen::MatrixXd columns = dense(Eigen::all, free);
    const Eigen::MatrixXd moves = columns.colPivHouseholderQr().solve(wanted - dense * start);
    Eigen::MatrixXd expected = start;
    expected(free, Eigen::all) += moves;
    EXPECT_LT((values - expected).norm(), 1e-10);
    EXPECT_EQ(values.row(0), start.row(0));
}

TEST(LeastSquares, WhatTheRowsLeaveOpenStaysWhereItIs) {
    // Only the difference of the two free unknowns is asked for: their mean stays.
    const Eigen::RowVector4d row(0.0, 1.0, 0.0, -1.0);
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(4, 1);
    values(1) = 1.0;
    SparseCholesky cholesky;
    minimise_rows(Rows(row.sparseView()), Eigen::MatrixXd::Constant(1, 1, 4.0), {1, 3}, cholesky, values,
                  Execution());
    EXPECT_LT((values - Eigen::Vector4d(0.0, 2.5, 0.0, -1.5)).norm(), 1e-9);
}

TEST(LeastSquares, RefusesRingsThatAreTooLong) {
    constexpr Index kCount = 10000;
    baselines::Setup setup;
    std::vector<Index> ring(kCount - 1);
    std::iota(ring.begin(), ring.end(), 1);
    setup.rings.append(ring.data(), ring.data() + ring.size(), RingKind::kClosed, true);
    setup.unknowns.number.assign(kCount, 0);
    setup.unknowns.rows = {0};
    const std::string refusal = message_of<InvalidInput>([&] { require_short_rings(setup); });
    EXPECT_TRUE(contains(refusal, "vertex 0 has 9999 neighbors that may move, and at most 2048"));
}

}  // namespace
}  // namespace meanvalue::tests
