// The similarity that best carries one set of points to another, and the rotation nearest to a 3 x 3 matrix.
#pragma once

#include <cstddef>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// x -> scale * rotation * x + translation.
struct Similarity {
    double scale = 1.0;
    Matrix3 rotation = Matrix3::Identity();
    Vector3 translation = Vector3::Zero();

    Vector3 apply(const Vector3& point) const { return scale * rotation * point + translation; }
};

/// Two sets of points about their centres: all that a fit needs to know.
struct Correlation {
    Vector3 from_centre = Vector3::Zero();
    Vector3 to_centre = Vector3::Zero();
    Matrix3 covariance = Matrix3::Zero();  ///< sum of to * from^T, both from their centers
    double from_spread = 0.0;              ///< sum of squared distances from the center
    double to_spread = 0.0;
};

/// @param from, to n x 3 each; @param points `count` row numbers, at least one. @param weights as of
/// fit_similarity().
Correlation correlate(const PositionsView& from, const PositionsView& to, const Index* points, std::size_t count,
                      const std::vector<double>& weights = {});

/// The rotation R that maximizes trace(R^T covariance); the smallest one where directions are missing.
/// @param covariance sum of to * from^T.
Matrix3 fit_rotation(const Matrix3& covariance);

/// The rotation R that maximizes trace(R^T M), as fit_rotation() gives it, several times as fast: the largest
/// eigenvalue of the 4 x 4 quaternion matrix by Newton's method, its eigenvector by cofactors (Horn 1987; Theobald
/// 2005). Where that is ill-conditioned (rank one, or nearly a reflection of a flat star), by fit_rotation().
/// The identity for the zero matrix, and where an entry is not a finite number.
Matrix3 closest_rotation(Matrix3 matrix);

/// The same of `count` matrices, in their place; four take as long as one.
void closest_rotations(Matrix3* matrices, Index count);

/// Least-squares fit over the points named (Umeyama 1991). What too few or collinear points leave open is
/// chosen nearest to the identity: a translation for one point, the smallest turn for two.
/// @param from, to n x 3 each; @param points at least one row number. @param weights n, what each row counts, above 0
/// for those of `points`; or empty: all the same.
Similarity fit_similarity(const PositionsView& from, const PositionsView& to, const std::vector<Index>& points,
                          const std::vector<double>& weights = {});

/// n x 3: all of `from` moved by the fit_similarity() of what is held; as it is where nothing is. @param is_held n
/// flags.
Positions carry_along(const PositionsView& from, const PositionsView& to, const std::vector<char>& is_held,
                      const std::vector<double>& weights = {});

}  // namespace meanvalue
