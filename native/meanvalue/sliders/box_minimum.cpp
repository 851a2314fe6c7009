#include <Eigen/Cholesky>
#include <vector>

#include "meanvalue/sliders/frame_fit.h"

namespace meanvalue {
namespace {

// The set of variables at a bound is found in a few steps; this many are never needed but for rounding.
constexpr int kMostSteps = 60;
constexpr int kMostHalvings = 30;

// Steps below it, in units of the variables, end the search.
constexpr double kLeastStep = 1e-10;

double value_at(const BoxProblem& problem, const Eigen::VectorXd& x) {
    return 0.5 * x.dot(problem.hessian * x) - problem.gradient.dot(x);
}

/// Those that no bound holds against the slope.
std::vector<Eigen::Index> find_free(const BoxProblem& problem, const Eigen::VectorXd& x,
                                    const Eigen::VectorXd& slope) {
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const bool at_lower = x(i) <= problem.lower(i) && slope(i) > 0.0;
        const bool at_upper = x(i) >= problem.upper(i) && slope(i) < 0.0;
        if (!at_lower && !at_upper) free.push_back(i);
    }
    return free;
}

/// Newton's step of the free variables; zero for the others.
Eigen::VectorXd newton_step(const BoxProblem& problem, const Eigen::VectorXd& slope,
                            const std::vector<Eigen::Index>& free) {
    const Eigen::MatrixXd hessian = problem.hessian(free, free);
    const Eigen::VectorXd step = hessian.llt().solve(-slope(free));
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(slope.size());
    whole(free) = step;
    return whole;
}

}  // namespace

Eigen::VectorXd minimise_in_box(const BoxProblem& problem, const Eigen::VectorXd& start) {
    const auto clip = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
        return x.cwiseMax(problem.lower).cwiseMin(problem.upper);
    };
    Eigen::VectorXd x = clip(start);
    double value = value_at(problem, x);
    for (int round = 0; round < kMostSteps; ++round) {
        const Eigen::VectorXd slope = problem.hessian * x - problem.gradient;
        const std::vector<Eigen::Index> free = find_free(problem, x, slope);
        if (free.empty()) break;
        Eigen::VectorXd step = newton_step(problem, slope, free);
        Eigen::VectorXd next = clip(x + step);
        double next_value = value_at(problem, next);
        for (int halving = 0; halving < kMostHalvings && next_value > value; ++halving) {
            step *= 0.5;
            next = clip(x + step);
            next_value = value_at(problem, next);
        }
        if (!(next_value <= value)) break;
        const double change = (next - x).cwiseAbs().maxCoeff();
        x = next;
        value = next_value;
        if (change < kLeastStep) break;
    }
    return x;
}

}  // namespace meanvalue
