#include "meanvalue/sliders/box_minimum.h"

#include <Eigen/Cholesky>
#include <vector>

namespace meanvalue {
namespace {

// The set of variables at a bound is found in a few steps; this many are never needed but for rounding.
constexpr int kMostSteps = 60;
constexpr int kMostHalvings = 30;

// Steps below it, in units of the variables, end the search.
constexpr double kLeastStep = 1e-10;

}  // namespace

Eigen::VectorXd minimise_in_box(const BoxProblem& problem, const Eigen::VectorXd& start) {
    const auto clip = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
        return x.cwiseMax(problem.lower).cwiseMin(problem.upper);
    };
    const auto value_at = [&](const Eigen::VectorXd& x) {
        return 0.5 * x.dot(problem.hessian * x) - problem.gradient.dot(x);
    };
    Eigen::VectorXd x = clip(start);
    for (int round = 0; round < kMostSteps; ++round) {
        const Eigen::VectorXd slope = problem.hessian * x - problem.gradient;
        std::vector<Eigen::Index> free;  // those that no bound holds against the slope
        for (Eigen::Index i = 0; i < x.size(); ++i) {
            const bool at_lower = x(i) <= problem.lower(i) && slope(i) > 0.0;
            const bool at_upper = x(i) >= problem.upper(i) && slope(i) < 0.0;
            if (!at_lower && !at_upper) free.push_back(i);
        }
        if (free.empty()) break;
        Eigen::VectorXd step = Eigen::VectorXd::Zero(x.size());
        const Eigen::MatrixXd hessian = problem.hessian(free, free);
        step(free) = Eigen::VectorXd(hessian.llt().solve(-slope(free)));
        const double value = value_at(x);
        Eigen::VectorXd next = clip(x + step);
        for (int halving = 0; halving < kMostHalvings && value_at(next) > value; ++halving) {
            step *= 0.5;
            next = clip(x + step);
        }
        if (!(value_at(next) <= value)) break;
        x.swap(next);
        if ((next - x).cwiseAbs().maxCoeff() < kLeastStep) break;
    }
    return x;
}

}  // namespace meanvalue
