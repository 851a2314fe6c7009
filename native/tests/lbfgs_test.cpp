#include "meanvalue/optimise/lbfgs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Vertices on a line; every third is fixed where `with_fixed`. What is minimised is given by each test.
struct Line {
    Unknowns unknowns;
    SparseMatrix matrix;  // lower triangle; tridiagonal, positive definite
    SupernodalFactor factor;
    SupernodalFactor::Workspace workspace;
    Positions start;

    explicit Line(Index count, bool with_fixed = true) {
        unknowns.number.assign(count, -1);
        for (Index v = 0; v < count; ++v) {
            if (with_fixed && v % 3 == 0) continue;
            unknowns.number[v] = static_cast<Index>(unknowns.free.size());
            unknowns.free.push_back(v);
        }
        std::vector<Eigen::Triplet<double, std::int64_t>> triplets;
        for (Index k = 0; k < size(); ++k) {
            triplets.emplace_back(k, k, 2.1);
            if (k > 0) triplets.emplace_back(k, k - 1, -1.0);
        }
        matrix.resize(size(), size());
        matrix.setFromTriplets(triplets.begin(), triplets.end());
        const Execution execution;
        factor.analyse(matrix, execution);
        EXPECT_TRUE(factor.factorise(matrix, execution));
        start.resize(count, 3);
        for (Index v = 0; v < count; ++v)
            start.row(v) << std::sin(v), std::cos(2.0 * v), std::sin(0.1 * v * v);
    }

    Preconditioner preconditioner() { return {factor, workspace}; }
    Index size() const { return static_cast<Index>(unknowns.free.size()); }
    Positions free_of(const Positions& positions) const { return rows_of(positions, unknowns.free); }

    /// x' A x / 2 - b x, whose minimum the returned function fills in.
    Lbfgs::Energy quadratic(const Positions& minimum) const {
        return [this, minimum](const Positions& positions, Positions& gradient) {
            const Positions offset = free_of(positions) - minimum;
            gradient = matrix.selfadjointView<Eigen::Lower>() * offset;
            return 0.5 * offset.cwiseProduct(gradient).sum();
        };
    }

    /// The same with a term of the fourth order, several times as strong at the start, that couples the coordinates.
    double steep(const Positions& positions, Positions& gradient) const {
        const Positions free = free_of(positions);
        gradient = matrix.selfadjointView<Eigen::Lower>() * free;
        double energy = 0.5 * free.cwiseProduct(gradient).sum();
        for (Index k = 0; k < size(); ++k) {
            const Vector3 offset = free.row(k).transpose() - Vector3(1.0, -0.5, 0.25);
            const double square = offset.squaredNorm();
            energy += 3.0 * square * square;
            gradient.row(k) += 12.0 * square * offset.transpose();
        }
        return energy;
    }
    Lbfgs::Energy steep_energy() const {
        return [this](const Positions& positions, Positions& gradient) { return steep(positions, gradient); };
    }

    LbfgsReport minimise(const Lbfgs::Energy& energy, const LbfgsOptions& options, Positions& positions) {
        Execution execution;
        return Lbfgs(unknowns).minimise(energy, preconditioner(), options, positions, execution);
    }
};

LbfgsOptions options_with(double step_tolerance, int max_iterations, int threads = 1) {
    LbfgsOptions options;
    options.step_tolerance = step_tolerance;
    options.max_iterations = max_iterations;
    options.threads = threads;
    return options;
}

void expect_never_rises(const std::vector<double>& energies) {
    for (std::size_t k = 1; k < energies.size(); ++k)
        EXPECT_LT(energies[k], energies[k - 1]) << "iteration " << k;
}

TEST(Lbfgs, OneStepEndsOnTheQuadraticOfItsMatrixOrOfASofterOneAndLaterOnesMakeUpForSinglePrecision) {
    Line line(1000);
    const Positions minimum = 0.3 * Positions::Ones(line.size(), 3);
    const auto quadratic = line.quadratic(minimum);
    // At a quarter of the energy a whole step is a quarter of the way.
    const auto soft = [&](const Positions& positions, Positions& gradient) {
        const double energy = 0.25 * quadratic(positions, gradient);
        gradient *= 0.25;
        return energy;
    };
    for (const Lbfgs::Energy& energy : {quadratic, Lbfgs::Energy(soft)}) {
        Positions positions = line.start;
        const LbfgsReport report = line.minimise(energy, options_with(0.0, 1), positions);
        // As exactly as the factor's single precision lets it.
        EXPECT_LT(largest_distance(line.free_of(positions), minimum), 1e-4);
        EXPECT_LT(report.energies.back(), 1e-9 * report.energies.front());
        EXPECT_LT(report.gradient, 1e-4 * report.initial_gradient);
    }
    Positions positions = line.start;
    const LbfgsReport report = line.minimise(quadratic, options_with(1e-12, 30), positions);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(largest_distance(line.free_of(positions), minimum), 1e-10);
    expect_never_rises(report.energies);
}

TEST(Lbfgs, EndsWhereTheGradientOfANonlinearFunctionVanishes) {
    for (const bool with_fixed : {true, false}) {
        Line line(5000, with_fixed);
        Positions positions = line.start;
        const LbfgsReport report = line.minimise(line.steep_energy(), options_with(1e-5, 300), positions);
        EXPECT_TRUE(report.converged);
        EXPECT_FALSE(report.at_limit);
        EXPECT_GT(report.iterations(), 5);
        expect_never_rises(report.energies);
        Positions gradient(line.size(), 3);
        EXPECT_EQ(line.steep(positions, gradient), report.energies.back());  // the positions given back are the last
        EXPECT_EQ(gradient.norm(), report.gradient);
        EXPECT_LT(gradient.norm(), 1e-5 * report.initial_gradient);
        for (Index v = 0; with_fixed && v < 5000; v += 3)
            EXPECT_EQ(positions.row(v), line.start.row(v)) << v;
    }
}

TEST(Lbfgs, WithPatienceASingleStepThatIsFarTooShortEndsIt) {
    const auto iterations = [](int patience) {
        Line line(300);
        const Positions minimum = line.free_of(line.start) + Positions::Constant(line.size(), 3, 1e-3);
        LbfgsOptions options = options_with(1e-2, 100);
        options.patience = patience;
        Positions positions = line.start;
        const LbfgsReport report = line.minimise(line.quadratic(minimum), options, positions);
        EXPECT_TRUE(report.converged);
        return report.iterations();
    };
    EXPECT_LT(iterations(20), iterations(0));
}

/// A quadratic for whose first three vertices the matrix is too soft by that much.
Lbfgs::Energy stiffened(const Line& line, const Positions& minimum, double stiffness) {
    const auto plain = line.quadratic(minimum);
    return [&line, plain, minimum, stiffness](const Positions& positions, Positions& gradient) {
        double energy = plain(positions, gradient);
        const Positions offset = line.free_of(positions) - minimum;
        energy += stiffness * offset.topRows<3>().squaredNorm();
        gradient.topRows<3>() += 2.0 * stiffness * offset.topRows<3>();
        return energy;
    };
}

TEST(Lbfgs, TheHistoryIsWorthItsKeep) {
    // Steps without a history would shorten by fifty times.
    Line line(900);
    Positions positions = line.start;
    const Lbfgs::Energy energy = stiffened(line, Positions::Zero(line.size(), 3), 50.0);
    const LbfgsReport report = line.minimise(energy, options_with(1e-9, 10), positions);
    EXPECT_LT(report.energies.back(), 1e-5 * report.energies.front());
    expect_never_rises(report.energies);
}

TEST(Lbfgs, AKeptHistoryEndsInTheSamePlaceAndCostsFewStepsWhereItMisleads) {
    const auto iterations_of_second = [](Line& line, double stiffness, bool keep) {
        Lbfgs minimiser(line.unknowns);
        Execution execution;
        Positions positions = line.start;
        LbfgsOptions options = options_with(1e-3, 100);
        minimiser.minimise(stiffened(line, Positions::Zero(line.size(), 3), stiffness), line.preconditioner(),
                           options, positions, execution);
        options.keep_history = keep;
        const Positions near = Positions::Constant(line.size(), 3, 0.1);
        const LbfgsReport report = minimiser.minimise(stiffened(line, near, stiffness), line.preconditioner(),
                                                      options, positions, execution);
        EXPECT_TRUE(report.converged);
        EXPECT_LT(largest_distance(line.free_of(positions), near), 1e-2);
        return report.iterations();
    };
    for (const double stiffness : {0.3, 3.0, 50.0}) {
        int kept = 0;
        int fresh = 0;
        for (Index count = 870; count < 930; count += 6) {  // rounding decides how many it takes on one line
            Line line(count);
            kept += iterations_of_second(line, stiffness, true);
            fresh += iterations_of_second(line, stiffness, false);
        }
        EXPECT_LE(2 * kept, 3 * fresh) << stiffness;
    }
}

TEST(Lbfgs, AnEnergyToleranceEndsTheLongTailAndNoFall) {
    Line line(5000);
    Positions exact = line.start, early = line.start;
    LbfgsOptions options = options_with(1e-7, 500);
    const LbfgsReport whole = line.minimise(line.steep_energy(), options, exact);
    options.energy_tolerance = 1e-3;
    options.step_tolerance = 1e-2;
    const LbfgsReport part = line.minimise(line.steep_energy(), options, early);
    EXPECT_TRUE(part.converged);
    EXPECT_LT(part.iterations(), whole.iterations());
    EXPECT_LT(part.energies.back(), 1.01 * whole.energies.back());
    // However short steps may be: not while the energy falls by more.
    options.step_tolerance = 1e9;
    Positions all_short = line.start;
    EXPECT_LT(line.minimise(line.steep_energy(), options, all_short).energies.back(), 1.01 * whole.energies.back());
}

TEST(Lbfgs, GivesTheSameBitsForAnyNumberOfThreads) {
    Line line(30000);
    Positions one = line.start;
    const LbfgsReport report = line.minimise(line.steep_energy(), options_with(1e-8, 40, 1), one);
    EXPECT_GT(report.iterations(), 5);
    for (const int threads : {2, 3}) {
        Positions more = line.start;
        EXPECT_EQ(line.minimise(line.steep_energy(), options_with(1e-8, 40, threads), more).energies,
                  report.energies);
        EXPECT_EQ(more, one) << threads;
    }
}

TEST(Lbfgs, NothingOfAnEarlierCallIsLeft) {
    Line line(1000);
    Execution execution;
    Lbfgs minimiser(line.unknowns);
    Positions first = line.start, again = line.start, other = 2.0 * line.start;
    minimiser.minimise(line.steep_energy(), line.preconditioner(), options_with(1e-8, 40), first, execution);
    minimiser.minimise(line.quadratic(line.free_of(line.start)), line.preconditioner(), options_with(1e-8, 5), other,
                       execution);
    minimiser.minimise(line.steep_energy(), line.preconditioner(), options_with(1e-8, 40), again, execution);
    EXPECT_EQ(first, again);
}

TEST(Lbfgs, AnIterationLimitIsKeptAndReported) {
    Line line(1000);
    for (const int limit : {0, 1, 3}) {
        Positions positions = line.start;
        const LbfgsReport report = line.minimise(line.steep_energy(), options_with(1e-12, limit), positions);
        EXPECT_EQ(report.iterations(), limit);
        EXPECT_TRUE(report.at_limit);
        EXPECT_FALSE(report.converged);
        EXPECT_EQ(positions == line.start, limit == 0);
    }
    // No step is needed at the minimum.
    Positions positions = line.start;
    EXPECT_TRUE(line.minimise(line.quadratic(line.free_of(line.start)), options_with(1e-12, 0), positions).converged);
    EXPECT_EQ(positions, line.start);
}

TEST(Lbfgs, AStartThatIsNotFiniteIsRefused) {
    Line line(100);
    Positions positions = line.start;
    positions(1, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(line.minimise(line.steep_energy(), options_with(1e-6, 10), positions), SolverFailure);
    positions(1, 0) = 1e200;  // its fourth power is not finite
    EXPECT_THROW(line.minimise(line.steep_energy(), options_with(1e-6, 10), positions), SolverFailure);
}

TEST(Lbfgs, StepsToWhereTheEnergyIsNoNumberAreShortened) {
    Line line(100);
    // x - log(x) has no value left of 0, where the first whole step would end.
    const auto energy = [&](const Positions& positions, Positions& gradient) {
        const Eigen::ArrayXXd free = line.free_of(positions).array();
        gradient = (10.0 - 10.0 / free).matrix();
        return 10.0 * (free - free.log()).sum();
    };
    Positions positions = Positions::Constant(100, 3, 5.0);
    const LbfgsReport report = line.minimise(energy, options_with(1e-5, 200), positions);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(largest_distance(line.free_of(positions), Positions::Ones(line.size(), 3)), 1e-4);
    expect_never_rises(report.energies);
}

TEST(Lbfgs, WhereNoStepHelpsItSaysThatItDidNotConverge) {
    Line line(100);
    const auto wrong_way = [&](const Positions& positions, Positions& gradient) {
        gradient = -line.free_of(positions);  // of the wrong sign
        return 0.5 * line.free_of(positions).squaredNorm();
    };
    Positions positions = line.start;
    const LbfgsReport report = line.minimise(wrong_way, options_with(1e-9, 50), positions);
    EXPECT_FALSE(report.converged);
    EXPECT_FALSE(report.at_limit);
    EXPECT_EQ(report.iterations(), 0);
    EXPECT_EQ(positions, line.start);
}

TEST(Lbfgs, ACancelLeavesAStateThatIsNotWorseThanTheStart) {
    Line line(3000);
    Positions scratch(line.size(), 3);
    const double at_start = line.steep(line.start, scratch);
    for (const int evaluations : {1, 2, 5, 10}) {
        Execution execution;
        int done = 0;
        std::vector<double> seen;
        const auto energy = [&](const Positions& positions, Positions& gradient) {
            if (++done == evaluations) execution.cancel();
            seen.push_back(line.steep(positions, gradient));
            return seen.back();
        };
        Positions positions = line.start;
        Lbfgs minimiser(line.unknowns);
        EXPECT_THROW(
            minimiser.minimise(energy, line.preconditioner(), options_with(1e-12, 100), positions, execution),
            Cancelled);
        EXPECT_EQ(done, evaluations) << "goes on after a cancel";
        const double energy_left = line.steep(positions, scratch);
        EXPECT_LE(energy_left, at_start);
        EXPECT_NE(std::find(seen.begin(), seen.end(), energy_left), seen.end()) << "half a step was taken";
    }
}

}  // namespace
}  // namespace meanvalue::tests
