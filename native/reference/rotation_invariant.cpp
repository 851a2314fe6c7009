#include "reference/rotation_invariant.h"

#include <Eigen/Eigenvalues>

#include "meanvalue/linalg/procrustes.h"
#include "reference/edge_laplacian.h"
#include "reference/laplacian.h"

namespace meanvalue::baselines {
namespace {

// Squared widths below this share of the squared length: on one line, where no twist is determined.
constexpr double kLeastWidth = 1e-12;

/// The turn of each vertex's frame, as a line of nine numbers.
using Turns = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;

Eigen::Map<Matrix3> turn_of(Turns& turns, Eigen::Index v) {
    return Eigen::Map<Matrix3>(turns.row(v).data());
}

bool on_one_line(const Correlation& points, const Matrix3& spread) {
    return points.from_spread == 0.0 ||
           Eigen::SelfAdjointEigenSolver<Matrix3>(spread, Eigen::EigenvaluesOnly).eigenvalues()(1) <=
               kLeastWidth * points.from_spread;
}

/// The rotation of an anchor, from where the anchors of its star are, or all of it.
Matrix3 anchor_turn(const Problem& problem, const EdgeWeights& edges, const std::vector<char>& is_anchor,
                    const Positions& placed, Index anchor) {
    std::vector<Index> star = {anchor};
    for (EdgeWeights::InnerIterator edge(edges, anchor); edge; ++edge)
        star.push_back(static_cast<Index>(edge.row()));
    std::vector<Index> anchors;
    for (const Index v : star) {
        if (is_anchor[v]) anchors.push_back(v);
    }
    const Correlation rest = correlate(problem.vertices, problem.vertices, anchors.data(), anchors.size());
    const std::vector<Index>& points = on_one_line(rest, rest.covariance) ? star : anchors;
    return fit_rotation(correlate(problem.vertices, placed, points.data(), points.size()).covariance);
}

}  // namespace

Positions rotation_invariant(const Problem& problem, Execution& execution) {
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    Positions positions = smooth_start(setup, execution);
    const EdgeLaplacian laplacian(uniform_weights(problem, execution), setup.is_fixed, execution);

    // A frame F_i is T_i times that at rest. |F_j - F_i R_ij|, with R_ij what is between them at rest, is |T_j - T_i|
    // for whichever orthonormal frames: they need not be known.
    std::vector<char> is_anchor(problem.vertices.rows(), 0);
    for (const Index anchor : problem.anchors)
        is_anchor[anchor] = 1;
    Turns turns(problem.vertices.rows(), 9);
    for (Index v = 0; v < turns.rows(); ++v)
        turn_of(turns, v).setIdentity();
    for (std::size_t k = 0; k < problem.anchors.size(); ++k) {
        execution.check_every(k);
        const Index anchor = problem.anchors[k];
        turn_of(turns, anchor) = anchor_turn(problem, laplacian.weights(), is_anchor, positions, anchor);
    }
    laplacian.place([](Index, Eigen::Index) { return Eigen::Matrix<double, 1, 9>::Zero(); }, turns, execution);
    for (const Index v : setup.unknowns.free)
        turn_of(turns, v) = fit_rotation(Matrix3(turn_of(turns, v)));

    laplacian.place(
        [&](Index i, Eigen::Index j) -> Eigen::RowVector3d {
            const Matrix3 mean = 0.5 * (turn_of(turns, i) + turn_of(turns, j));
            return (problem.vertices.row(i) - problem.vertices.row(j)) * mean.transpose();
        },
        positions, execution);
    return positions;
}

}  // namespace meanvalue::baselines
