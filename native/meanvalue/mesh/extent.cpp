#include "meanvalue/mesh/extent.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

constexpr int kDirections = 100;

using Directions = Eigen::Matrix<double, 3, kDirections>;

/// Spread evenly over half of the sphere along a spiral; a width is the same from both sides.
Directions spiral() {
    const double golden_angle = 3.14159265358979323846 * (3.0 - std::sqrt(5.0));
    Directions directions;
    for (int k = 0; k < kDirections; ++k) {
        const double height = 1.0 - (k + 0.5) / kDirections;
        const double radius = std::sqrt(1.0 - height * height);
        const auto [sine, cosine] = sine_cosine(golden_angle * k);
        directions.col(k) << radius * cosine, radius * sine, height;
    }
    return directions;
}

}  // namespace

double mean_diagonal(const PositionsView& positions, int threads, const Execution& execution) {
    if (positions.rows() == 0) return 0.0;
    const Directions directions = principal_axes(positions, execution) * spiral();
    std::vector<double> widths(kDirections);
    parallel_items(kDirections, threads, execution, [&](int, std::size_t k) {
        const Vector3 direction = directions.col(static_cast<Eigen::Index>(k));
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (Eigen::Index v = 0; v < positions.rows(); ++v) {
            const double along = positions.row(v).dot(direction);
            low = std::min(low, along);
            high = std::max(high, along);
        }
        widths[k] = high - low;
    });
    const double squares = std::inner_product(widths.begin(), widths.end(), widths.begin(), 0.0);
    // Three widths across each other make a diagonal; each has the same mean of squares.
    return std::sqrt(3.0 * squares / kDirections);
}

Matrix3 principal_axes(const PositionsView& positions, const Execution& execution) {
    const auto count = static_cast<double>(positions.rows());
    if (positions.rows() == 0) return Matrix3::Identity();
    const Eigen::RowVector3d centre = mean_row(positions).transpose();
    Matrix3 moments = Matrix3::Zero();
    execution.check();
    for (Eigen::Index v = 0; v < positions.rows(); ++v) {
        const Eigen::RowVector3d arm = positions.row(v) - centre;
        moments.noalias() += arm.transpose() * arm;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(moments / count);
    const Vector3& variances = solver.eigenvalues();  // ascending
    const double least_gap = std::min(variances(1) - variances(0), variances(2) - variances(1));
    if (!(least_gap > kCoincident * variances(2))) return Matrix3::Identity();
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
        const bool is_skewed = std::abs(third(c)) > kNegligible * count * variances(c) * std::sqrt(variances(c));
        if ((is_skewed ? third(c) : later(c)) < 0.0) axes.col(c) *= -1.0;
    }
    return axes;
}

double signed_volume(const PositionsView& positions, const TrianglesView& faces) {
    if (positions.rows() == 0) return 0.0;
    const Vector3 origin = positions.row(0);
    double sum = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        const auto corner = [&](int c) -> Vector3 { return Vector3(positions.row(faces(f, c))) - origin; };
        sum += corner(0).dot(corner(1).cross(corner(2)));
    }
    return sum / 6.0;
}

bool is_closed(const PositionsView& positions, const TrianglesView& faces) {
    Vector3 sum = Vector3::Zero();
    double size = 0.0;
    for (Index f = 0; f < faces.rows(); ++f) {
        const Vector3 corner = positions.row(faces(f, 0));
        const Vector3 area =
            (Vector3(positions.row(faces(f, 1))) - corner).cross(Vector3(positions.row(faces(f, 2))) - corner);
        sum += area;
        size += area.norm();
    }
    return sum.norm() <= kNegligible * size;
}

}  // namespace meanvalue
