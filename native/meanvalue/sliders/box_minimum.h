// Convex quadratic programs with bounds, small and dense.
#pragma once

#include <Eigen/Core>

namespace meanvalue {

/// A quadratic function of s variables within a box.
struct BoxProblem {
    const Eigen::MatrixXd& hessian;   ///< s x s, positive definite
    const Eigen::VectorXd& gradient;  ///< s, the negative gradient at zero
    const Eigen::VectorXd& lower;     ///< s
    const Eigen::VectorXd& upper;     ///< s, not below `lower`
};

/// The minimum of 1/2 x^T H x - g^T x within the box, by projected Newton steps (Bertsekas 1982): variables at a
/// bound that the gradient presses against stay there, the others take a Newton step, clipped to the box.
/// @param start s, where it begins; it is clipped first.
Eigen::VectorXd minimise_in_box(const BoxProblem& problem, const Eigen::VectorXd& start);

}  // namespace meanvalue
