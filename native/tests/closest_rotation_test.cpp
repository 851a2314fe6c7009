
#include <cmath>
#include <limits>
#include <random>

#include "meanvalue/linalg/procrustes.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

class Random {
  public:
    double normal() { return deviate_(engine_); }
    Vector3 vector() { return {normal(), normal(), normal()}; }
    Matrix3 matrix() {
        Matrix3 result;
        for (int column = 0; column < 3; ++column)
            result.col(column) = vector();
        return result;
    }
    Matrix3 rotation() {
        return Eigen::Quaterniond(normal(), normal(), normal(), normal()).normalized().toRotationMatrix();
    }
    /// A matrix with these singular values, the last one negative for a reflection.
    Matrix3 with_values(const Vector3& values) { return rotation() * values.asDiagonal() * rotation(); }

  private:
    std::mt19937 engine_{1};
    std::normal_distribution<double> deviate_;
};

void expect_rotation(const Matrix3& rotation) {
    EXPECT_LT((rotation * rotation.transpose() - Matrix3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
}

/// What the best rotation has more of than this one, as a share of the matrix.
double short_of_best(const Matrix3& matrix, const Matrix3& rotation) {
    const double best = (fit_rotation(matrix).transpose() * matrix).trace();
    return (best - (rotation.transpose() * matrix).trace()) / matrix.norm();
}

void expect_same_as_fit(const Matrix3& matrix) {
    const Matrix3 rotation = closest_rotation(matrix);
    expect_rotation(rotation);
    EXPECT_LT((rotation - fit_rotation(matrix)).norm(), 1e-10) << matrix;
    EXPECT_LT(short_of_best(matrix, rotation), 1e-13) << matrix;
}

TEST(ClosestRotation, IsTheFitOfRandomMatrices) {
    Random random;
    for (int k = 0; k < 5000; ++k) {
        const Matrix3 matrix = random.matrix();
        const Matrix3 rotation = closest_rotation(matrix);
        expect_rotation(rotation);
        // One in some thousands of them is nearly undecided between two rotations; all are equally good.
        EXPECT_LT(short_of_best(matrix, rotation), 1e-12) << matrix;
        const Vector3 values = Eigen::JacobiSVD<Matrix3>(matrix).singularValues();
        const double gap = values(1) + (matrix.determinant() < 0.0 ? -values(2) : values(2));
        if (gap > 0.01 * values(0)) {
            EXPECT_LT((rotation - fit_rotation(matrix)).norm(), 1e-10) << matrix;
        }
    }
}

TEST(ClosestRotation, OfARotationIsItself) {
    Random random;
    for (int k = 0; k < 1000; ++k) {
        const Matrix3 rotation = random.rotation();
        EXPECT_LT((closest_rotation(rotation) - rotation).norm(), 1e-12) << rotation;
        EXPECT_LT((closest_rotation(3.0 * rotation) - rotation).norm(), 1e-12) << rotation;
    }
    // Half turns, whose quaternion has no real part.
    for (const Vector3& axis : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(0.6, 0, 0.8)}) {
        const Matrix3 rotation = 2.0 * axis * axis.transpose() - Matrix3::Identity();
        EXPECT_LT((closest_rotation(rotation) - rotation).norm(), 1e-12) << axis.transpose();
    }
}

TEST(ClosestRotation, IsTheFitOfFlatStarsAndReflections) {
    Random random;
    for (int k = 0; k < 1000; ++k) {
        for (const Vector3& values : {Vector3(1.0, std::abs(random.normal()) + 0.01, 0.0), Vector3(1.0, 1.0, 0.0),
                                      Vector3(1.0, 0.5, 1e-12 * random.normal()), Vector3(3.0, 2.0, -1.0),
                                      Vector3(1.0, 0.9, -0.6), Vector3(1.0, 0.3, -1e-3)})
            expect_same_as_fit(random.with_values(values));
    }
}

TEST(ClosestRotation, IsAsGoodAsTheFitWhereSeveralAreBest) {
    Random random;
    for (int k = 0; k < 300; ++k) {
        // The gap between the best rotation and the next closes: to zero, and through where cofactors lose digits.
        for (const double gap : {0.0, 1e-14, 1e-10, 1e-7, 1e-5, 1e-3}) {
            for (const Vector3& values : {Vector3(1.0, 0.5, -0.5 + gap), Vector3(1.0, 1.0, -1.0 + gap),
                                          Vector3(1.0, gap, 0.0), Vector3(1.0, gap, -gap)}) {
                const Matrix3 matrix = random.with_values(values);
                const Matrix3 rotation = closest_rotation(matrix);
                expect_rotation(rotation);
                EXPECT_LT(short_of_best(matrix, rotation), 1e-12) << values.transpose();
            }
        }
    }
}

TEST(ClosestRotation, OfALineTurnedNearlyRoundIsARotation) {
    Random random;
    for (int k = 0; k < 300; ++k) {
        const Vector3 from = random.vector().normalized();
        const Vector3 aside = from.cross(random.vector()).normalized();
        for (const double off : {0.0, 1e-8, 1e-6, 3e-6, 1e-5, 1e-4, 1e-2}) {
            const Vector3 to = (off * aside - from).normalized();
            const Matrix3 rotation = fit_rotation(to * from.transpose());
            expect_rotation(rotation);
            EXPECT_LT((rotation * from - to).norm(), 1e-5) << off;
        }
    }
}

TEST(ClosestRotation, DoesNotDependOnScale) {
    Random random;
    for (int k = 0; k < 100; ++k) {
        const Matrix3 matrix = random.with_values({1.0, 0.7, 0.2});
        for (const double scale : {1e-300, 1e-165, 1e-161, 1e-154, 1e-100, 1e-20, 1e20, 1e100, 1e154, 1e165, 1e300})
            EXPECT_LT((closest_rotation(scale * matrix) - fit_rotation(matrix)).norm(), 1e-10) << scale;
    }
}

TEST(ClosestRotation, OfNothingAndOfWhatIsNoNumberIsTheIdentity) {
    EXPECT_EQ(closest_rotation(Matrix3::Zero()), Matrix3::Identity());
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Random random;
    for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
        for (Eigen::Index k = 0; k < 9; ++k) {
            Matrix3 matrix = random.matrix();
            matrix(k) = bad;
            EXPECT_EQ(closest_rotation(matrix), Matrix3::Identity()) << bad << " in place " << k;
        }
    }
}

}  // namespace
}  // namespace meanvalue::tests
