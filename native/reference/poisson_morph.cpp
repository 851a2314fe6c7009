#include "reference/poisson_morph.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue::baselines {
namespace {

// Cotangents: positive, so that the matrix is definite; finite, where a triangle has no area.
constexpr double kLeastCotangent = 1e-3;
constexpr double kMostCotangent = 1e4;

/// Two edges of a triangle and its normal, as long as these are.
Matrix3 frame_of(const PositionsView& shape, const TrianglesView& faces, Index f) {
    Matrix3 frame;
    frame.col(0) = (shape.row(faces(f, 1)) - shape.row(faces(f, 0))).transpose();
    frame.col(1) = (shape.row(faces(f, 2)) - shape.row(faces(f, 0))).transpose();
    const Vector3 area = frame.col(0).cross(frame.col(1));
    const double length = area.norm();
    frame.col(2) = length > 0.0 ? Vector3(area / std::sqrt(length)) : Vector3::Zero();
    return frame;
}

/// The map of a triangle at `share` of its way.
Matrix3 map_of(const PositionsView& first, const PositionsView& second, const TrianglesView& faces, Index f,
               double share) {
    const Matrix3 inverse = frame_of(first, faces, f).inverse();
    if (!inverse.allFinite()) return Matrix3::Identity();
    const Matrix3 map = frame_of(second, faces, f) * inverse;
    const Matrix3 rotation = fit_rotation(map);
    const Eigen::AngleAxisd turn(rotation);
    const Matrix3 stretch = rotation.transpose() * map;
    return Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix() *
           ((1.0 - share) * Matrix3::Identity() + share * stretch);
}

double cotangent(const Vector3& a, const Vector3& b) {
    const double value = a.dot(b) / a.cross(b).norm();
    return std::isnan(value) ? kLeastCotangent : std::clamp(value, kLeastCotangent, kMostCotangent);
}

}  // namespace

Positions poisson_morph(const PositionsView& first, const PositionsView& second, const TrianglesView& faces,
                        double share, Execution& execution) {
    require_finite(first, "first");
    require_finite(second, "second");
    if (first.rows() != second.rows()) {
        throw InvalidInput(message("second has ", second.rows(), " vertices, but first has ", first.rows()));
    }
    if (!std::isfinite(share)) throw InvalidInput(message("share is ", share, "; give a number"));
    const auto vertices = static_cast<Index>(first.rows());
    require_triangles(vertices, faces);
    const Components parts = find_components(first, faces, std::vector<char>(vertices, 0), execution);
    std::vector<double> diagonal(vertices, 0.0);
    std::vector<Eigen::Triplet<double, SparseMatrix::StorageIndex>> entries;
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(vertices, 3);
    for (Index f = 0; f < faces.rows(); ++f) {
        execution.check_every(f);
        const Matrix3 map = map_of(first, second, faces, f, share);
        for (int c = 0; c < 3; ++c) {
            const Index a = faces(f, c);
            const Index b = faces(f, (c + 1) % 3);
            const Vector3 opposite = first.row(faces(f, (c + 2) % 3));
            const double weight = 0.5 * cotangent(Vector3(first.row(a)) - opposite, Vector3(first.row(b)) - opposite);
            const Vector3 edge = weight * (map * Vector3(first.row(a) - first.row(b)));
            sums.row(a) += edge.transpose();
            sums.row(b) -= edge.transpose();
            diagonal[a] += weight;
            diagonal[b] += weight;
            entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
        }
    }
    for (const Component& part : parts.parts) {
        const Index v = part.first_vertex;
        const double held = diagonal[v] > 0.0 ? diagonal[v] : 1.0;
        sums.row(v) += held * ((1.0 - share) * first.row(v) + share * second.row(v));
        diagonal[v] += held;
    }
    for (Index v = 0; v < vertices; ++v)
        entries.emplace_back(v, v, diagonal[v]);
    SparseMatrix lower(vertices, vertices);
    lower.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky cholesky;
    cholesky.analyse(lower, execution);
    if (!cholesky.factorise(lower, execution))
        throw SolverFailure(message("the Laplacian of ", vertices, " vertices is not positive definite"));
    Positions result = cholesky.solve(sums, execution);
    require_finite_result(result, "share");
    return result;
}

}  // namespace meanvalue::baselines
