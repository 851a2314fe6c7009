#include "meanvalue/linalg/preconditioner.h"

#include <Eigen/Cholesky>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr Index kRows = 40;

/// A chain of springs, with strong ones to the ground at some rows.
struct Chain {
    SparseMatrix matrix;
    SupernodalFactor factor;
    SupernodalFactor::Workspace workspace;
    Execution execution;

    explicit Chain(const std::vector<Index>& rows, const std::vector<double>& strengths) {
        Eigen::MatrixXd dense = without(rows, strengths, 0.0);
        std::vector<Eigen::Triplet<double, std::int64_t>> triplets;
        for (Index k = 0; k < kRows; ++k) {
            triplets.emplace_back(k, k, dense(k, k));
            if (k > 0) triplets.emplace_back(k, k - 1, dense(k, k - 1));
        }
        matrix.resize(kRows, kRows);
        matrix.setFromTriplets(triplets.begin(), triplets.end());
        factor.analyse(matrix, execution);
        EXPECT_TRUE(factor.factorise(matrix, execution));
    }

    /// Dense, with `lost` of each strength taken off.
    static Eigen::MatrixXd without(const std::vector<Index>& rows, const std::vector<double>& strengths,
                                   double lost) {
        Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kRows, kRows);
        for (Index k = 0; k < kRows; ++k) {
            dense(k, k) = 2.05;
            if (k > 0) dense(k, k - 1) = dense(k - 1, k) = -1.0;
        }
        for (std::size_t k = 0; k < rows.size(); ++k)
            dense(rows[k], rows[k]) += (1.0 - lost) * strengths[k];
        return dense;
    }
};

Positions right_hand_sides() {
    Positions result(kRows, 3);
    for (Index k = 0; k < kRows; ++k)
        result.row(k) << std::sin(k), std::cos(3.0 * k), 1.0;
    return result;
}

TEST(Preconditioner, SolvesAsIfSpringsThatDoNotCountHadNotBeenFactored) {
    const std::vector<Index> rows = {3, 4, 17, 30};
    const std::vector<double> strengths = {0.5, 200.0, 20.0, 3.0};
    Chain chain(rows, strengths);
    for (const double lost : {1.0, 0.4, 0.0}) {
        std::vector<double> amounts;
        amounts.reserve(strengths.size());
        for (const double strength : strengths)
            amounts.push_back(lost * strength);
        DiagonalDowndate downdate;
        downdate.set(chain.factor, rows, amounts, 1, chain.execution, chain.workspace);
        Positions solution(kRows, 3);
        Preconditioner{chain.factor, chain.workspace, &downdate}.solve(right_hand_sides(), solution, 1,
                                                                       chain.execution);
        const Positions expected = Chain::without(rows, strengths, lost).llt().solve(right_hand_sides());
        EXPECT_LT((solution - expected).norm(), 2e-3 * expected.norm()) << lost;
    }
}

TEST(Preconditioner, AmountsMayChange) {
    const std::vector<Index> rows = {3, 20};
    const std::vector<double> strengths = {10.0, 10.0};
    Chain chain(rows, strengths);
    DiagonalDowndate changed;
    for (const std::vector<double>& amounts :
         {std::vector<double>{10.0, 0.0}, std::vector<double>{0.0, 0.0}, std::vector<double>{10.0, 10.0}})
        changed.set(chain.factor, rows, amounts, 1, chain.execution, chain.workspace);
    DiagonalDowndate fresh;
    fresh.set(chain.factor, rows, {10.0, 10.0}, 1, chain.execution, chain.workspace);
    Positions first = right_hand_sides(), second = first;
    changed.correct(first, 1, chain.execution);
    fresh.correct(second, 2, chain.execution);
    EXPECT_GT((first - right_hand_sides()).norm(), 0.1);
    EXPECT_LT((first - second).norm(), 1e-6 * first.norm());
    changed.set(chain.factor, rows, {0.0, 0.0}, 1, chain.execution, chain.workspace);
    Positions same = right_hand_sides();
    changed.correct(same, 1, chain.execution);
    EXPECT_EQ(same, right_hand_sides());
}

}  // namespace
}  // namespace meanvalue::tests
