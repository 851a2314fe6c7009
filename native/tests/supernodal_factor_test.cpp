#include "meanvalue/solver/supernodal_factor.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <random>
#include <thread>

#include "meanvalue/common/abandon.h"
#include "meanvalue/common/errors.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Triplets = std::vector<Eigen::Triplet<double, std::int64_t>>;

SparseMatrix from_triplets(Index size, const Triplets& triplets) {
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix;
}

SparseMatrix lower_of(const SparseMatrix& symmetric) {
    return symmetric.triangularView<Eigen::Lower>();
}

/// The sum of squares of what a vertex is apart from the weighted mean of its ring, every tenth vertex held softly.
SparseMatrix bilaplacian(const Mesh& mesh, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> weight(0.5, 1.5);
    Triplets triplets;
    for (Index face = 0; face < mesh.faces.rows(); ++face) {
        for (int corner = 0; corner < 3; ++corner) {
            const Index a = mesh.faces(face, corner);
            const Index b = mesh.faces(face, (corner + 1) % 3);
            const double w = weight(random) / 6.0;
            triplets.insert(triplets.end(), {{a, b, -w}, {b, a, -w}, {a, a, w}, {b, b, w}});
        }
    }
    const SparseMatrix laplacian = from_triplets(mesh.vertex_count(), triplets);
    Triplets held;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        held.emplace_back(v, v, v % 10 == 0 ? 1.0 : 1e-4);
    return lower_of(SparseMatrix(laplacian.transpose()) * laplacian + from_triplets(mesh.vertex_count(), held));
}

SparseMatrix diagonal(Index size) {
    Triplets triplets;
    for (Index k = 0; k < size; ++k)
        triplets.emplace_back(k, k, 1.0 + k % 7);
    return from_triplets(size, triplets);
}

/// Every entry of the lower triangle, as a mesh of one very long ring would have.
SparseMatrix full(Index size) {
    Triplets triplets;
    for (Index column = 0; column < size; ++column) {
        for (Index row = column; row < size; ++row)
            triplets.emplace_back(row, column, row == column ? 2.0 * size : 1.0 / (1 + row - column));
    }
    return from_triplets(size, triplets);
}

/// The first column has an entry in every row.
SparseMatrix arrow(Index size) {
    Triplets triplets;
    for (Index row = 0; row < size; ++row) {
        triplets.emplace_back(row, row, row == 0 ? size : 2.0);
        if (row > 0) triplets.emplace_back(row, 0, 0.5);
    }
    return from_triplets(size, triplets);
}

SparseMatrix in_parts(const std::vector<SparseMatrix>& parts) {
    Triplets triplets;
    std::int64_t first = 0;
    for (const SparseMatrix& part : parts) {
        for (Eigen::Index column = 0; column < part.cols(); ++column) {
            for (SparseMatrix::InnerIterator entry(part, column); entry; ++entry)
                triplets.emplace_back(first + entry.row(), first + column, entry.value());
        }
        first += part.cols();
    }
    return from_triplets(static_cast<Index>(first), triplets);
}

struct Case {
    std::string name;
    SparseMatrix lower;
};

void PrintTo(const Case& item, std::ostream* stream) {
    *stream << item.name;
}

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const Index size : {1, 2, 3, 4, 5, 7, 8, 9, 13, 100})
        all.push_back({"full " + std::to_string(size), full(size)});
    all.push_back({"diagonal", diagonal(1000)});
    all.push_back({"large diagonal", diagonal(40000)});
    all.push_back({"arrow", arrow(500)});
    for (const Mesh& mesh : all_classes())
        all.push_back({mesh.name, bilaplacian(mesh)});
    const SparseMatrix large = bilaplacian(grid(100, 90, 0.1));
    all.push_back({"large grid", large});
    all.push_back({"large sphere", bilaplacian(sphere(6))});
    all.push_back({"long grid", bilaplacian(grid(3000, 4, 0.0))});
    all.push_back({"parts", in_parts({large, full(3), diagonal(50), bilaplacian(torus(60, 40)), full(1)})});
    all.push_back({"many parts", in_parts(std::vector<SparseMatrix>(3000, full(5)))});
    return all;
}

Positions solved(SupernodalFactor& factor, const Positions& right_hand_sides, int threads) {
    Positions solution(right_hand_sides.rows(), 3);
    factor.solve(right_hand_sides, solution, threads, Execution());
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

INSTANTIATE_TEST_SUITE_P(Matrices, SupernodalFactorOf, testing::ValuesIn(cases()),
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
    factor_.solve(positions, positions, 2, Execution());
    EXPECT_EQ(positions, solved(factor_, right_hand_sides_, 1));
}

TEST_F(LargeSystem, NumbersFarFromOneLoseNothing) {
    const Positions expected = solved(factor_, right_hand_sides_, 1);
    for (const double scale : {std::ldexp(1.0, -300), std::ldexp(1.0, 300)})
        EXPECT_EQ(Positions(solved(factor_, right_hand_sides_ * scale, 1) / scale), expected);
    EXPECT_EQ(solved(factor_, Positions::Zero(lower_.cols(), 3), 1), Positions::Zero(lower_.cols(), 3));
}

TEST_F(LargeSystem, ACancelledSolveLeavesTheFactorAsItWas) {
    const Positions expected = solved(factor_, right_hand_sides_, 2);
    Execution cancelled;
    cancelled.cancel();
    Positions solution(lower_.cols(), 3);
    for (const int threads : {1, 2})
        EXPECT_THROW(factor_.solve(right_hand_sides_, solution, threads, cancelled), Cancelled);
    EXPECT_EQ(solved(factor_, right_hand_sides_, 2), expected);
}

TEST_F(LargeSystem, ACancelledFactorisationCanBeRepeated) {
    const Positions expected = solved(factor_, right_hand_sides_, 2);
    Execution cancelled;
    cancelled.cancel();
    EXPECT_THROW(factor_.factorise(lower_, cancelled), Cancelled);
    EXPECT_THROW(SupernodalFactor().analyse(lower_, cancelled), Cancelled);
    // At any time: the flag is set while it runs.
    for (const int delay : {0, 1, 3, 10, 30}) {
        Execution execution;
        std::thread canceller([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(delay));
            execution.cancel();
        });
        try {
            if (!factor_.analysed()) factor_.analyse(lower_, execution);
            factor_.factorise(lower_, execution);
        } catch (const Cancelled&) {  // as the case may be
        }
        canceller.join();
    }
    factor_.analyse(lower_, Execution());
    ASSERT_TRUE(factor_.factorise(lower_, Execution()));
    EXPECT_EQ(solved(factor_, right_hand_sides_, 2), expected);
    wait_for_abandoned();
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
