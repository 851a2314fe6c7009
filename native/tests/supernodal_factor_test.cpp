#include "meanvalue/linalg/supernodal_factor.h"

#include <atomic>
#include <random>

#include "meanvalue/common/errors.h"
#include "meanvalue/linalg/sparse_cholesky.h"
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

/// Random forests in postorder, some nodes much heavier than others.
std::vector<Index> random_forest(Index count, std::mt19937& random) {
    std::vector<Index> parents(count, -1);
    std::vector<Index> roots;
    for (Index node = 0; node < count; ++node) {
        // A new node takes over some of the last roots, or none: a leaf.
        for (unsigned k = random() % 4; k > 0 && !roots.empty(); --k) {
            parents[roots.back()] = node;
            roots.pop_back();
        }
        roots.push_back(node);
    }
    return parents;
}

TEST(EliminationTasks, CoverTheForestAndRunEachAfterWhatItWaitsFor) {
    std::mt19937 random(7);
    for (const Index count : {0, 1, 2, 50, 3000}) {
        const std::vector<Index> parents = random_forest(count, random);
        std::vector<std::int64_t> weights(count);
        for (std::int64_t& weight : weights)
            weight = random() % 100 == 0 ? 200000 : random() % 3000;
        const std::vector<EliminationTask> tasks = cut_into_tasks(parents, weights);
        Index covered = 0;
        for (const EliminationTask& task : tasks) {
            EXPECT_EQ(task.begin, covered);
            EXPECT_GT(task.end, task.begin);
            for (Index node = task.begin; node < task.end; ++node) {
                const Index parent = parents[node];
                if (parent < 0 || parent < task.end) continue;
                ASSERT_GE(task.parent, 0);
                EXPECT_GE(parent, tasks[task.parent].begin);
                EXPECT_LT(parent, tasks[task.parent].end);
            }
            covered = task.end;
        }
        EXPECT_EQ(covered, count);

        for (const int threads : {1, 2, 5}) {
            std::vector<std::atomic<int>> state(tasks.size());  // 1 after up, 2 after down
            const auto up = [&](Index t, int) {
                for (const Index child : tasks[t].children)
                    EXPECT_EQ(state[child], 1);
                state[t] = 1;
            };
            const auto down = [&](Index t, int worker) {
                EXPECT_LT(worker, threads);
                EXPECT_EQ(state[t], 1);
                if (tasks[t].parent >= 0) {
                    EXPECT_EQ(state[tasks[t].parent], 2);
                }
                state[t] = 2;
            };
            TaskRunner().run(tasks, threads, Execution(), up, down);
            for (const std::atomic<int>& of_task : state)
                EXPECT_EQ(of_task, 2);
        }
    }
}

TEST(EliminationTasks, AnExceptionEndsTheRun) {
    std::mt19937 random(3);
    const std::vector<Index> parents = random_forest(2000, random);
    const auto tasks = cut_into_tasks(parents, std::vector<std::int64_t>(2000, 5000));
    ASSERT_GT(tasks.size(), 10U);
    const auto fail = [&](Index t, int) {
        if (t == 5) throw SolverFailure("no");
    };
    const auto nothing = [](Index, int) {};
    TaskRunner runner;
    for (const int threads : {1, 3}) {
        EXPECT_THROW(runner.run(tasks, threads, Execution(), fail, nothing), SolverFailure);
        EXPECT_THROW(runner.run(tasks, threads, Execution(), nothing, fail), SolverFailure);
        EXPECT_NO_THROW(runner.run(tasks, threads, Execution(), nothing, nothing));
    }
}

}  // namespace
}  // namespace meanvalue::tests
