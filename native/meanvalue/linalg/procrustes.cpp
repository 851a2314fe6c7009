#include "meanvalue/linalg/procrustes.h"

#include <Eigen/SVD>

namespace meanvalue {
namespace {

// Singular values of the covariance below this share of the largest carry no direction.
constexpr double kRankTolerance = 1e-10;

// Below it the targets have collapsed to a point, and so would everything carried along: keep the size.
constexpr double kLeastScale = 1e-6;

}  // namespace

Matrix3 fit_rotation(const Matrix3& covariance) {
    const Eigen::JacobiSVD<Matrix3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vector3& values = svd.singularValues();
    if (values(0) == 0.0) return Matrix3::Identity();
    if (values(1) < kRankTolerance * values(0)) {
        // Its length is not 1 for nearly opposite directions.
        const auto turn = Eigen::Quaterniond::FromTwoVectors(svd.matrixV().col(0), svd.matrixU().col(0));
        return turn.normalized().toRotationMatrix();
    }
    Vector3 signs(1.0, 1.0, 1.0);
    if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs(2) = -1.0;
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Correlation correlate(const PositionsView& from, const PositionsView& to, const Index* points, std::size_t count,
                      const std::vector<double>& weights) {
    const auto weight_of = [&](Index v) { return weights.empty() ? 1.0 : weights[v]; };
    Correlation sums;
    double total = 0.0;
    for (const Index* v = points; v != points + count; ++v) {
        total += weight_of(*v);
        sums.from_centre += weight_of(*v) * Vector3(from.row(*v));
        sums.to_centre += weight_of(*v) * Vector3(to.row(*v));
    }
    sums.from_centre /= total;
    sums.to_centre /= total;
    for (const Index* v = points; v != points + count; ++v) {
        const Vector3 before = Vector3(from.row(*v)) - sums.from_centre;
        const Vector3 after = Vector3(to.row(*v)) - sums.to_centre;
        sums.covariance += weight_of(*v) * after * before.transpose();
        sums.from_spread += weight_of(*v) * before.squaredNorm();
        sums.to_spread += weight_of(*v) * after.squaredNorm();
    }
    return sums;
}

Similarity fit_similarity(const PositionsView& from, const PositionsView& to, const std::vector<Index>& points,
                          const std::vector<double>& weights) {
    const Correlation sums = correlate(from, to, points.data(), points.size(), weights);
    Similarity result;
    result.rotation = fit_rotation(sums.covariance);
    const double scale =
        sums.from_spread > 0.0 ? (result.rotation.transpose() * sums.covariance).trace() / sums.from_spread : 1.0;
    if (scale > kLeastScale) result.scale = scale;
    result.translation = sums.to_centre - result.scale * result.rotation * sums.from_centre;
    return result;
}

Positions carry_along(const PositionsView& from, const PositionsView& to, const std::vector<char>& is_held,
                      const std::vector<double>& weights) {
    std::vector<Index> held;
    for (std::size_t v = 0; v < is_held.size(); ++v)
        if (is_held[v]) held.push_back(static_cast<Index>(v));
    Positions carried = from;
    if (held.empty()) return carried;
    const Similarity fit = fit_similarity(from, to, held, weights);
    for (Index v = 0; v < carried.rows(); ++v)
        carried.row(v) = fit.apply(from.row(v).transpose());
    return carried;
}

}  // namespace meanvalue
