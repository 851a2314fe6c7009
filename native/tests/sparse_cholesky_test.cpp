#include <atomic>
#include <limits>
#include <thread>

#include "meanvalue/linalg/multifrontal.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "tests/matrices.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Eigen::MatrixXd solved(const SparseMatrix& lower, const Eigen::MatrixXd& right_hand_sides, int threads) {
    SparseCholesky cholesky;
    cholesky.analyse(lower, Execution(), threads);
    EXPECT_TRUE(cholesky.factorise(lower, Execution(), threads));
    return cholesky.solve(right_hand_sides, Execution());
}

double residual(const SparseMatrix& lower, const Eigen::MatrixXd& x, const Eigen::MatrixXd& right_hand_sides) {
    const Eigen::MatrixXd rest = lower.selfadjointView<Eigen::Lower>() * x - right_hand_sides;
    return rest.norm() / right_hand_sides.norm();
}

class SparseCholeskyOf : public testing::TestWithParam<Case> {};

TEST_P(SparseCholeskyOf, SolvesWithTheSameBitsForAnyNumberOfThreads) {
    const SparseMatrix& lower = GetParam().lower;
    const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(lower.cols(), 5);
    const Eigen::MatrixXd expected = solved(lower, right_hand_sides, 1);
    EXPECT_LT(residual(lower, expected, right_hand_sides), 1e-10);
    for (const int threads : {2, 3, 4})
        EXPECT_EQ(solved(lower, right_hand_sides, threads), expected);
}

TEST_P(SparseCholeskyOf, BothKindsOfKernelsAgreeToRounding) {
    const SparseMatrix& lower = GetParam().lower;
    const SupernodalPattern pattern = find_supernodes(lower, 1, Execution());
    const auto values_by = [&](const FrontKernels& kernels) {
        std::vector<Eigen::MatrixXd> panels(pattern.count());
        const auto keep = [&](Index s, const FrontShape& shape, const double* panel) {
            panels[s].setZero(pattern.row_count(s), pattern.width(s));
            for (Index c = 0; c < pattern.width(s); ++c) {
                for (Index row = c; row < pattern.row_count(s); ++row)
                    panels[s](row, c) = panel[shape.place(row) + std::int64_t{c} * kBlockRows];
            }
        };
        EXPECT_TRUE(factor_fronts(pattern, lower, kernels, 2, keep, Execution()));
        return panels;
    };
    const auto fast = values_by(front_kernels(InstructionSet::kFastest));
    const auto portable = values_by(front_kernels(InstructionSet::kPortable));
    for (Index s = 0; s < pattern.count(); ++s) {
        const Eigen::MatrixXd a = fast[s].triangularView<Eigen::Lower>();
        const Eigen::MatrixXd b = portable[s].triangularView<Eigen::Lower>();
        EXPECT_LT((a - b).norm(), 1e-9 * a.norm());
    }
}

INSTANTIATE_TEST_SUITE_P(Matrices, SparseCholeskyOf, testing::ValuesIn(all_matrices()),
                         [](const auto& item) { return std::to_string(item.index); });

TEST(SparseCholesky, SolvesNothing) {
    EXPECT_EQ(solved(SparseMatrix(0, 0), Eigen::MatrixXd(0, 3), 2).cols(), 3);
}

TEST(SparseCholesky, SaysWhatIsNotPositiveDefinite) {
    const SparseMatrix lower = bilaplacian(grid(60, 60, 0.1));
    const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(lower.cols(), 1);
    SparseCholesky cholesky;
    cholesky.analyse(lower, Execution(), 2);
    for (const double bad : {-1.0, 0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        for (const int threads : {1, 2}) {
            SparseMatrix spoilt = lower;
            spoilt.coeffRef(1234, 1234) = bad;
            EXPECT_FALSE(cholesky.factorise(spoilt, Execution(), threads)) << bad;
            const SupernodalPattern pattern = find_supernodes(spoilt, threads, Execution());
            EXPECT_FALSE(factor_fronts(
                pattern, spoilt, front_kernels(InstructionSet::kPortable), threads,
                [](Index, const FrontShape&, const double*) {}, Execution()))
                << bad;
        }
    }
    ASSERT_TRUE(cholesky.factorise(lower, Execution()));
    EXPECT_EQ(cholesky.solve(right_hand_sides, Execution()), solved(lower, right_hand_sides, 1));
}

TEST(SparseCholesky, ManyAtOnceAreAsExactAsOne) {
    const SparseMatrix lower = in_blocks(bilaplacian(torus(60, 40)));
    const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(lower.cols(), 3);
    const Eigen::MatrixXd expected = solved(lower, right_hand_sides, 1);
    std::atomic<int> same{0};
    std::vector<std::thread> threads;
    threads.reserve(6);
    for (int k = 0; k < 6; ++k)
        threads.emplace_back([&, k] { same += solved(lower, right_hand_sides, 1 + k % 3) == expected ? 1 : 0; });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(same, 6);
}

TEST(SparseCholesky, IsCancelledAnywhereAndWorksOn) {
    const SparseMatrix lower = in_blocks(bilaplacian(grid(30, 30, 0.1)));
    const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(lower.cols(), 2);
    const Eigen::MatrixXd expected = solved(lower, right_hand_sides, 1);
    SparseCholesky cholesky;
    cancelled_everywhere([&](Execution& execution) {
        if (!cholesky.analysed()) cholesky.analyse(lower, execution, 2);
        cholesky.factorise(lower, execution, 2);
        EXPECT_EQ(cholesky.solve(right_hand_sides, execution), expected);
    });
    EXPECT_TRUE(cholesky.factorise(lower, Execution()));
    EXPECT_EQ(cholesky.solve(right_hand_sides, Execution()), expected);
}

}  // namespace
}  // namespace meanvalue::tests
