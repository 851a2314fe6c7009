#include "reference/laplacian_surface_editing.h"

#include <Eigen/Eigenvalues>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/linalg/procrustes.h"
#include "reference/least_squares.h"

namespace meanvalue::baselines {
namespace {

// Rotations about an axis with less than this share of the largest moment of inertia are undetermined: the star is
// collinear.
constexpr double kRankTolerance = 1e-9;

Matrix3 pseudo_inverse(const Matrix3& symmetric) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(symmetric);
    Vector3 inverse = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
        if (solver.eigenvalues()(k) > kRankTolerance * solver.eigenvalues()(2))
            inverse(k) = 1.0 / solver.eigenvalues()(k);
    }
    return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// The rotation of each row's star (a vertex and its ring) that carries it best from `rest` to `positions`.
std::vector<Matrix3> star_rotations(const Setup& setup, const PositionsView& rest, const Positions& positions,
                                    const Execution& execution) {
    std::vector<Matrix3> rotations(setup.unknowns.rows.size());
    parallel_for(static_cast<Index>(rotations.size()), setup.threads, execution, [&](Index begin, Index end) {
        for (Index row = begin; row < end; ++row) {
            const Index v = setup.unknowns.rows[row];
            Matrix3 covariance = Matrix3::Zero();
            for (const Index* j = setup.rings.begin(v); j != setup.rings.end(v); ++j)
                covariance += (positions.row(*j) - positions.row(v)).transpose() * (rest.row(*j) - rest.row(v));
            rotations[row] = fit_rotation(covariance);
        }
    });
    return rotations;
}

/// (L V')_i - T_i(V') R_i delta_i, where T_i = s I + [h]_x fits the turned rest star R_i q_k to that of V'. With q_k
/// relative to the star's centroid, the pseudo-inverse of the paper's A_i falls apart: for R_i = I it is
/// s = sum_k q_k . v'_k / sum_k |q_k|^2 and h = M^+ sum_k q_k x v'_k, M = sum_k (|q_k|^2 I - q_k q_k^T).
Rows editing_rows(const Setup& setup, const PositionsView& rest, const std::vector<Matrix3>& rotations,
                  const Execution& execution) {
    std::vector<RowEntry> entries;
    std::vector<Index> star;
    std::vector<Vector3> offsets;  // q_k
    for (std::size_t row = 0; row < setup.unknowns.rows.size(); ++row) {
        execution.check_every(row);
        const Index v = setup.unknowns.rows[row];
        const Index valence = setup.rings.valence(v);
        star.assign(setup.rings.begin(v), setup.rings.end(v));
        star.push_back(v);
        offsets.clear();
        Vector3 sum = Vector3::Zero();  // relative to v, so that nothing is lost far from the origin
        for (const Index k : star) {
            offsets.emplace_back((rest.row(k) - rest.row(v)).transpose());
            sum += offsets.back();
        }
        double spread = 0.0;
        Matrix3 inertia = Matrix3::Zero();
        for (Vector3& offset : offsets) {
            offset -= sum / (valence + 1.0);
            spread += offset.squaredNorm();
            inertia += offset.squaredNorm() * Matrix3::Identity() - offset * offset.transpose();
        }
        const Matrix3& rotation = rotations[row];
        const Vector3 delta = -sum / valence;
        const Matrix3 turn = -rotation * cross_matrix(delta) * pseudo_inverse(inertia);
        const Vector3 growth = spread > 0.0 ? Vector3(rotation * delta / spread) : Vector3::Zero();
        for (std::size_t k = 0; k < star.size(); ++k) {
            const double laplacian = star[k] == v ? 1.0 : -1.0 / valence;
            const Matrix3 block = laplacian * Matrix3::Identity() - growth * (rotation * offsets[k]).transpose() -
                                  turn * cross_matrix(offsets[k]) * rotation.transpose();
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c)
                    entries.emplace_back(3 * static_cast<std::int64_t>(row) + r, 3 * star[k] + c, block(r, c));
            }
        }
    }
    execution.check();
    Rows rows(3 * static_cast<Eigen::Index>(setup.unknowns.rows.size()), 3 * rest.rows());
    rows.setFromTriplets(entries.begin(), entries.end());
    return rows;
}

}  // namespace

Positions laplacian_surface_editing(const Problem& problem, const LaplacianSurfaceEditingOptions& options,
                                    Execution& execution) {
    if (options.rounds < 1) throw InvalidInput(message("rounds is ", options.rounds, "; give 1 or more"));
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    require_short_rings(setup);
    std::vector<Index> free;
    for (const Index v : setup.unknowns.free)
        free.insert(free.end(), {3 * v, 3 * v + 1, 3 * v + 2});
    std::vector<Matrix3> rotations(setup.unknowns.rows.size(), Matrix3::Identity());
    SparseCholesky cholesky;
    Positions positions = setup.start;
    Eigen::MatrixXd coordinates = Eigen::Map<const Eigen::VectorXd>(positions.data(), positions.size());
    for (int round = 0; round < options.rounds; ++round) {
        execution.set_progress(static_cast<double>(round) / options.rounds);
        if (round > 0) rotations = star_rotations(setup, problem.vertices, positions, execution);
        const Rows rows = editing_rows(setup, problem.vertices, rotations, execution);
        minimise_rows(rows, Eigen::VectorXd::Zero(rows.rows()), free, cholesky, coordinates, execution);
        positions = Eigen::Map<const Positions>(coordinates.data(), positions.rows(), 3);
    }
    return positions;
}

}  // namespace meanvalue::baselines
