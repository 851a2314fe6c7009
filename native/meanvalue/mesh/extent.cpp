#include "meanvalue/mesh/extent.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

constexpr int kDirections = 100;
constexpr Index kBlock = 32;
// Differences of variance, as a share of the largest, and third moments, of that of one point at that distance, below
// which they are rounding.
constexpr double kDistinct = 1e-6;
constexpr double kSkewed = 1e-9;

using Directions = Eigen::Matrix<double, 3, kDirections>;
using Extremes = Eigen::Matrix<double, 1, kDirections>;

/// Spread evenly over half of the sphere along a spiral; a width is the same from both sides.
Directions spiral() {
    const double golden_angle = 3.14159265358979323846 * (3.0 - std::sqrt(5.0));
    const auto [sine_of_step, cosine_of_step] = sine_cosine(golden_angle);
    Directions directions;
    double cosine = 1.0;
    double sine = 0.0;
    for (int k = 0; k < kDirections; ++k) {
        const double height = 1.0 - (k + 0.5) / kDirections;
        const double radius = std::sqrt(1.0 - height * height);
        directions.col(k) << radius * cosine, radius * sine, height;
        const double next = cosine * cosine_of_step - sine * sine_of_step;
        sine = cosine * sine_of_step + sine * cosine_of_step;
        cosine = next;
    }
    return directions;
}

}  // namespace

double mean_diagonal(const PositionsView& positions, int threads, const Execution& execution) {
    if (positions.rows() == 0) return 0.0;
    const Directions directions = principal_axes(positions, execution) * spiral();
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Extremes highest = Extremes::Constant(-kFar);
    Extremes lowest = Extremes::Constant(kFar);
    std::mutex merging;
    parallel_for(static_cast<Index>(positions.rows()), threads, execution, [&](Index begin, Index end) {
        Extremes high = Extremes::Constant(-kFar);
        Extremes low = Extremes::Constant(kFar);
        Eigen::Matrix<double, kBlock, kDirections> along;
        for (Index first = begin; first < end; first += kBlock) {
            const Index count = std::min(kBlock, end - first);
            along.topRows(count).noalias() = positions.middleRows(first, count).lazyProduct(directions);
            high = high.cwiseMax(along.topRows(count).colwise().maxCoeff());
            low = low.cwiseMin(along.topRows(count).colwise().minCoeff());
        }
        const std::lock_guard<std::mutex> lock(merging);
        highest = highest.cwiseMax(high);
        lowest = lowest.cwiseMin(low);
    });
    // Three widths across each other make a diagonal; each has the same mean of squares.
    return std::sqrt(3.0 * (highest - lowest).squaredNorm() / kDirections);
}

Matrix3 principal_axes(const PositionsView& positions, const Execution& execution) {
    const auto count = static_cast<double>(positions.rows());
    if (positions.rows() == 0) return Matrix3::Identity();
    const Eigen::RowVector3d centre = positions.colwise().mean();
    Matrix3 moments = Matrix3::Zero();
    execution.check();
    for (Eigen::Index v = 0; v < positions.rows(); ++v) {
        const Eigen::RowVector3d arm = positions.row(v) - centre;
        moments.noalias() += arm.transpose() * arm;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(moments / count);
    const Vector3& variances = solver.eigenvalues();  // ascending
    const double least_gap = std::min(variances(1) - variances(0), variances(2) - variances(1));
    if (!(least_gap > kDistinct * variances(2))) return Matrix3::Identity();
    Matrix3 axes = solver.eigenvectors();
    Eigen::RowVector3d third = Eigen::RowVector3d::Zero();
    Eigen::RowVector3d later = Eigen::RowVector3d::Zero();
    execution.check();
    for (Eigen::Index v = 0; v < positions.rows(); ++v) {
        const Eigen::RowVector3d along = (positions.row(v) - centre) * axes;
        third += along.cwiseProduct(along).cwiseProduct(along);
        later += static_cast<double>(v) * along;
    }
    for (int c = 0; c < 3; ++c) {
        const bool is_skewed = std::abs(third(c)) > kSkewed * count * variances(c) * std::sqrt(variances(c));
        if ((is_skewed ? third(c) : later(c)) < 0.0) axes.col(c) *= -1.0;
    }
    return axes;
}

}  // namespace meanvalue
