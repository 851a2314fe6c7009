#include "meanvalue/linalg/closest_rotation.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

constexpr int kMostSteps = 50;
// Relative error of the largest eigenvalue: the rotation's error is its root where two eigenvalues are near each
// other.
constexpr double kStepTolerance = 1e-15;
// Squared norm of the eigenvector by cofactors, for a matrix of norm 1: it vanishes with the gap between the two
// largest eigenvalues, and digits are lost with it.
constexpr double kLeastEigenvector = 1e-12;
// Squares of the entries of smaller matrices would be lost.
constexpr double kLeastNorm = 1e-140;

/// The symmetric 4 x 4 matrix whose largest eigenvector is the quaternion of the rotation (Horn 1987), less x I, with
/// the 2 x 2 minors of its upper and its lower two rows, of which determinant and cofactors are made.
struct QuaternionMatrix {
    Eigen::Matrix4d k;
    double s0, s1, s2, s3, s4, s5;  // rows 0 and 1
    double t0, t1, t2, t3, t4, t5;  // rows 2 and 3

    QuaternionMatrix(const Matrix3& m, double x) {
        const double b = m(2, 1) - m(1, 2), c = m(0, 2) - m(2, 0), d = m(1, 0) - m(0, 1);
        const double f = m(1, 0) + m(0, 1), g = m(0, 2) + m(2, 0), i = m(2, 1) + m(1, 2);
        k << m(0, 0) + m(1, 1) + m(2, 2) - x, b, c, d,  //
            b, m(0, 0) - m(1, 1) - m(2, 2) - x, f, g,   //
            c, f, -m(0, 0) + m(1, 1) - m(2, 2) - x, i,  //
            d, g, i, -m(0, 0) - m(1, 1) + m(2, 2) - x;
        s0 = k(0, 0) * k(1, 1) - k(1, 0) * k(0, 1);
        s1 = k(0, 0) * k(1, 2) - k(1, 0) * k(0, 2);
        s2 = k(0, 0) * k(1, 3) - k(1, 0) * k(0, 3);
        s3 = k(0, 1) * k(1, 2) - k(1, 1) * k(0, 2);
        s4 = k(0, 1) * k(1, 3) - k(1, 1) * k(0, 3);
        s5 = k(0, 2) * k(1, 3) - k(1, 2) * k(0, 3);
        t5 = k(2, 2) * k(3, 3) - k(3, 2) * k(2, 3);
        t4 = k(2, 1) * k(3, 3) - k(3, 1) * k(2, 3);
        t3 = k(2, 1) * k(3, 2) - k(3, 1) * k(2, 2);
        t2 = k(2, 0) * k(3, 3) - k(3, 0) * k(2, 3);
        t1 = k(2, 0) * k(3, 2) - k(3, 0) * k(2, 2);
        t0 = k(2, 0) * k(3, 1) - k(3, 0) * k(2, 1);
    }

    double determinant() const { return s0 * t5 - s1 * t4 + s2 * t3 + s3 * t2 - s4 * t1 + s5 * t0; }

    /// The longest column of the cofactors: an eigenvector of the eigenvalue x, and the best conditioned one.
    Eigen::Vector4d null_vector() const {
        Eigen::Matrix4d c;
        c(0, 0) = k(1, 1) * t5 - k(1, 2) * t4 + k(1, 3) * t3;
        c(0, 1) = -k(0, 1) * t5 + k(0, 2) * t4 - k(0, 3) * t3;
        c(0, 2) = k(3, 1) * s5 - k(3, 2) * s4 + k(3, 3) * s3;
        c(0, 3) = -k(2, 1) * s5 + k(2, 2) * s4 - k(2, 3) * s3;
        c(1, 1) = k(0, 0) * t5 - k(0, 2) * t2 + k(0, 3) * t1;
        c(1, 2) = -k(3, 0) * s5 + k(3, 2) * s2 - k(3, 3) * s1;
        c(1, 3) = k(2, 0) * s5 - k(2, 2) * s2 + k(2, 3) * s1;
        c(2, 2) = k(3, 0) * s4 - k(3, 1) * s2 + k(3, 3) * s0;
        c(2, 3) = -k(2, 0) * s4 + k(2, 1) * s2 - k(2, 3) * s0;
        c(3, 3) = k(2, 0) * s3 - k(2, 1) * s1 + k(2, 2) * s0;
        c.triangularView<Eigen::StrictlyLower>() = c.transpose();
        Eigen::Index longest = 0;
        c.diagonal().cwiseAbs().maxCoeff(&longest);
        return c.col(longest);
    }
};

/// Where Newton's method or the eigenvector would fail.
Matrix3 slowly_closest_rotation(const Matrix3& matrix) {
    // Singular values are not defined of what is no number.
    return matrix.allFinite() ? fit_rotation(matrix) : Matrix3::Identity();
}

}  // namespace

Matrix3 closest_rotation(const Matrix3& matrix) {
    const double norm = matrix.norm();
    if (!(norm > kLeastNorm)) return slowly_closest_rotation(matrix);
    const Matrix3 m = matrix / norm;
    // Characteristic polynomial x^4 + c2 x^2 + c1 x + c0 of the quaternion matrix.
    const double c2 = -2.0 * m.squaredNorm();
    const double c1 = -8.0 * m.determinant();
    const double c0 = QuaternionMatrix(m, 0.0).determinant();
    // From above, every Newton step goes down towards the largest root, and is shorter than the one before; sqrt(3)
    // bounds it. At a multiple root the slope ends as rounding: a step by it that is not shorter may go anywhere.
    double x = 1.7320508075688772;
    double last = x;
    for (int step = 0; step < kMostSteps; ++step) {
        const double slope = (4.0 * x * x + 2.0 * c2) * x + c1;
        if (!(slope > 0.0)) break;
        const double down = (((x * x + c2) * x + c1) * x + c0) / slope;
        if (!(down > kStepTolerance * x && down < last)) break;
        x -= down;
        last = down;
    }
    const Eigen::Vector4d q = QuaternionMatrix(m, x).null_vector();
    if (!(q.squaredNorm() > kLeastEigenvector)) return slowly_closest_rotation(matrix);
    return Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
}

}  // namespace meanvalue
