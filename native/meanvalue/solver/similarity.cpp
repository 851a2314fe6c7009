#include "meanvalue/solver/similarity.h"

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
        return Eigen::Quaterniond::FromTwoVectors(svd.matrixV().col(0), svd.matrixU().col(0)).toRotationMatrix();
    }
    Vector3 signs(1.0, 1.0, 1.0);
    if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs(2) = -1.0;
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Similarity fit_similarity(const PositionsView& from, const PositionsView& to, const std::vector<Index>& points,
                          const std::vector<double>& weights) {
    const auto weight_of = [&](Index v) { return weights.empty() ? 1.0 : weights[v]; };
    double total = 0.0;
    Vector3 from_centre = Vector3::Zero();
    Vector3 to_centre = Vector3::Zero();
    for (const Index v : points) {
        total += weight_of(v);
        from_centre += weight_of(v) * Vector3(from.row(v));
        to_centre += weight_of(v) * Vector3(to.row(v));
    }
    from_centre /= total;
    to_centre /= total;

    Matrix3 covariance = Matrix3::Zero();
    double spread = 0.0;
    for (const Index v : points) {
        const Vector3 offset = Vector3(from.row(v)) - from_centre;
        covariance += weight_of(v) * (Vector3(to.row(v)) - to_centre) * offset.transpose();
        spread += weight_of(v) * offset.squaredNorm();
    }
    Similarity result;
    result.rotation = fit_rotation(covariance);
    const double scale = spread > 0.0 ? (result.rotation.transpose() * covariance).trace() / spread : 1.0;
    if (scale > kLeastScale) result.scale = scale;
    result.translation = to_centre - result.scale * result.rotation * from_centre;
    return result;
}

}  // namespace meanvalue
