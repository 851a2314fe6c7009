#include "meanvalue/baselines/laplacian_surface_editing.h"

#include <Eigen/Eigenvalues>

#include "meanvalue/baselines/laplacian.h"
#include "meanvalue/common/cross_matrix.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/solver/similarity.h"

namespace meanvalue::baselines {
namespace {

// Turns about an axis with less than this share of the largest moment of inertia cannot be told: a collinear star.
constexpr double kRankTolerance = 1e-9;

Matrix3 pseudo_inverse(const Matrix3& symmetric) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(symmetric);
    Vector3 inverse = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
        if (solver.eigenvalues()(k) > kRankTolerance * solver.eigenvalues()(2)) inverse(k) = 1.0 / solver.eigenvalues()(k);
    }
    return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// (L V')_i - T_i(V') delta_i, with T_i fitted to the stars (a vertex and its ring) of `shape`. With q_k relative to
/// the star's centroid, the pseudo-inverse of the paper's A_i falls apart into
/// s = sum_k q_k . v'_k / sum_k |q_k|^2 and h = M^+ sum_k q_k x v'_k, M = sum_k (|q_k|^2 I - q_k q_k^T).
/// @param coordinates delta, one line a row.
LinearRows<3> editing_rows(const Setup& setup, const PositionsView& shape, const Positions& coordinates,
                           const Execution& execution) {
    LinearRows<3> rows;
    std::vector<Index> star;
    for (std::size_t row = 0; row < setup.unknowns.rows.size(); ++row) {
        execution.check_every(row);
        const Index v = setup.unknowns.rows[row];
        star.assign(setup.rings.begin(v), setup.rings.end(v));
        star.push_back(v);
        const Vector3 origin = shape.row(v);
        Vector3 centroid = Vector3::Zero();  // relative to v, so that nothing is lost far from the origin
        for (const Index k : star)
            centroid += (Vector3(shape.row(k)) - origin) / static_cast<double>(star.size());
        double spread = 0.0;
        Matrix3 inertia = Matrix3::Zero();
        for (const Index k : star) {
            const Vector3 offset = Vector3(shape.row(k)) - origin - centroid;
            spread += offset.squaredNorm();
            inertia += offset.squaredNorm() * Matrix3::Identity() - offset * offset.transpose();
        }
        const Vector3 delta = coordinates.row(row);
        const Matrix3 turn = -cross_matrix(delta) * pseudo_inverse(inertia);
        const Vector3 growth = spread > 0.0 ? Vector3(delta / spread) : Vector3::Zero();
        for (const Index k : star) {
            const Vector3 offset = Vector3(shape.row(k)) - origin - centroid;
            const double laplacian = k == v ? 1.0 : -1.0 / setup.rings.valence(v);
            rows.add(k, laplacian * Matrix3::Identity() - growth * offset.transpose() - turn * cross_matrix(offset));
        }
        rows.end_row();
    }
    return rows;
}

/// The coordinates of the rest shape, each turned by the rotation that carries its ring best.
Positions turned_coordinates(const Setup& setup, const PositionsView& rest, const Positions& coordinates,
                             const Positions& positions, const Execution& execution) {
    Positions turned(coordinates.rows(), 3);
    parallel_for(static_cast<Index>(coordinates.rows()), setup.threads, execution, [&](Index begin, Index end) {
        for (Index row = begin; row < end; ++row) {
            const Index v = setup.unknowns.rows[row];
            Matrix3 covariance = Matrix3::Zero();
            for (const Index* j = setup.rings.begin(v); j != setup.rings.end(v); ++j) {
                covariance += (positions.row(*j) - positions.row(v)).transpose() * (rest.row(*j) - rest.row(v));
            }
            turned.row(row) = coordinates.row(row) * fit_rotation(covariance).transpose();
        }
    });
    return turned;
}

}  // namespace

Positions laplacian_surface_editing(const Problem& problem, const LaplacianSurfaceEditingOptions& options,
                                    Execution& execution) {
    if (options.rounds < 1) throw InvalidInput(message("rounds is ", options.rounds, "; give 1 or more"));
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    const Positions coordinates = uniform_laplacian(setup).apply(problem.vertices);
    const Positions none = Positions::Zero(coordinates.rows(), 3);
    SparseCholesky cholesky;
    Positions positions = setup.start;
    minimise_rows(editing_rows(setup, problem.vertices, coordinates, execution), none, setup.unknowns, cholesky,
                  positions, execution);
    for (int round = 1; round < options.rounds; ++round) {
        execution.set_progress(static_cast<double>(round) / options.rounds);
        const Positions turned = turned_coordinates(setup, problem.vertices, coordinates, positions, execution);
        minimise_rows(editing_rows(setup, positions, turned, execution), none, setup.unknowns, cholesky, positions,
                      execution);
    }
    return positions;
}

}  // namespace meanvalue::baselines
