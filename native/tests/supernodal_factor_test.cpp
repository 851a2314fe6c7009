#include "meanvalue/linalg/supernodal_factor.h"

#include <cmath>

#include "tests/matrices.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Positions solved(const SupernodalFactor& factor, const Positions& right_hand_sides, int threads) {
    Positions solution(right_hand_sides.rows(), 3);
    SupernodalFactor::Workspace workspace;
    factor.solve(right_hand_sides, solution, threads, Execution(), workspace);
    return solution;
}

/// The root of the sum of x' matrix x.
double energy_norm(const SparseMatrix& lower, const Positions& x) {
    return std::sqrt(x.cwiseProduct(Positions(lower.selfadjointView<Eigen::Lower>() * x)).sum());
}

class SupernodalFactorOf : public testing::TestWithParam<Case> {
  protected:
    const SparseMatrix& lower_ = GetParam().lower;
    Positions right_hand_sides_ = Positions::Random(lower_.cols(), 3);
    Execution execution_;
};

TEST_P(SupernodalFactorOf, FindsWhatTheExactFactorFindsWithTheSameBitsForAnyThreads) {
    SparseCholesky exact;
    exact.analyse(lower_, execution_);
    ASSERT_TRUE(exact.factorise(lower_, execution_));
    const Positions expected = exact.solve(right_hand_sides_, execution_);
    SupernodalFactor factor;
    factor.analyse(lower_, execution_);
    ASSERT_TRUE(factor.factorise(lower_, execution_));
    EXPECT_EQ(factor.size(), lower_.cols());
    EXPECT_GT(factor.bytes(), 4U * lower_.cols());
    const Positions found = solved(factor, right_hand_sides_, 1);
    EXPECT_LT(energy_norm(lower_, found - expected), 1e-4 * energy_norm(lower_, expected));
    for (const int threads : {1, 2, 3, 8})
        EXPECT_EQ(solved(factor, right_hand_sides_, threads), found) << threads << " threads";
}

TEST_P(SupernodalFactorOf, FactorsOtherValuesOnTheSamePattern) {
    SupernodalFactor factor;
    factor.analyse(lower_, execution_);
    ASSERT_TRUE(factor.factorise(lower_, execution_));
    const Positions before = solved(factor, right_hand_sides_, 2);
    ASSERT_TRUE(factor.factorise(4.0 * lower_, execution_));
    // Powers of two round nothing.
    EXPECT_EQ(Positions(4.0 * solved(factor, right_hand_sides_, 2)), before);
}

INSTANTIATE_TEST_SUITE_P(Matrices, SupernodalFactorOf, testing::ValuesIn(all_matrices()),
                         [](const auto& item) { return std::to_string(item.index); });

/// One for all tests that look at the way rather than at the values.
class LargeSystem : public testing::Test {
  protected:
    SparseMatrix lower_ = bilaplacian(grid(120, 120, 0.1));
    Positions right_hand_sides_ = Positions::Random(lower_.cols(), 3);
    SupernodalFactor factor_;

    void SetUp() override {
        factor_.analyse(lower_, Execution());
        ASSERT_TRUE(factor_.factorise(lower_, Execution()));
    }
};

TEST_F(LargeSystem, SolvesInPlace) {
    Positions positions = right_hand_sides_;
    SupernodalFactor::Workspace workspace;
    factor_.solve(positions, positions, 2, Execution(), workspace);
    EXPECT_EQ(positions, solved(factor_, right_hand_sides_, 1));
}

TEST_F(LargeSystem, NumbersFarFromOneLoseNothing) {
    const Positions expected = solved(factor_, right_hand_sides_, 1);
    for (const double scale : {std::ldexp(1.0, -300), std::ldexp(1.0, 300)})
        EXPECT_EQ(Positions(solved(factor_, right_hand_sides_ * scale, 1) / scale), expected);
    EXPECT_EQ(solved(factor_, Positions::Zero(lower_.cols(), 3), 1), Positions::Zero(lower_.cols(), 3));
}

TEST_F(LargeSystem, IsCancelledAnywhereAndWorksOn) {
    const Positions expected = solved(factor_, right_hand_sides_, 2);
    Positions solution(lower_.cols(), 3);
    SupernodalFactor::Workspace workspace;
    for (const int threads : {1, 2}) {
        cancelled_everywhere([&](Execution& execution) { factor_.factorise(lower_, execution, threads); });
        cancelled_everywhere(
            [&](Execution& execution) { factor_.solve(right_hand_sides_, solution, threads, execution, workspace); });
        EXPECT_EQ(solution, expected);
    }
}

TEST_F(LargeSystem, SaysThatAMatrixIsNotPositiveDefiniteAndFactorsTheNext) {
    const Positions expected = solved(factor_, right_hand_sides_, 2);
    EXPECT_FALSE(factor_.factorise(-lower_, Execution()));
    ASSERT_TRUE(factor_.factorise(lower_, Execution()));
    EXPECT_EQ(solved(factor_, right_hand_sides_, 2), expected);
}

TEST_F(LargeSystem, AnotherPatternMayFollow) {
    const SparseMatrix other = full(20);
    factor_.analyse(other, Execution());
    ASSERT_TRUE(factor_.factorise(other, Execution()));
    const Positions sides = Positions::Random(20, 3);
    const Positions residual = other.selfadjointView<Eigen::Lower>() * solved(factor_, sides, 2) - sides;
    EXPECT_LT(residual.norm(), 1e-5 * sides.norm());
}

}  // namespace
}  // namespace meanvalue::tests
