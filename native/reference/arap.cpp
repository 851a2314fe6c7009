#include "reference/arap.h"

#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "reference/edge_laplacian.h"
#include "reference/laplacian.h"

namespace meanvalue::baselines {
namespace {

/// The rotation that carries the star of vertex `v` best from `rest` to `positions`. @return what is left over.
double fit_star(const EdgeWeights& weights, const PositionsView& rest, const Positions& positions, Index v,
                Matrix3& rotation) {
    const auto edge_of = [v](const PositionsView& shape, Index j) {
        return Vector3((shape.row(v) - shape.row(j)).transpose());
    };
    Matrix3 covariance = Matrix3::Zero();
    for (EdgeWeights::InnerIterator edge(weights, v); edge; ++edge) {
        const auto j = static_cast<Index>(edge.row());
        covariance += edge.value() * edge_of(positions, j) * edge_of(rest, j).transpose();
    }
    rotation = fit_rotation(covariance);
    double energy = 0.0;
    for (EdgeWeights::InnerIterator edge(weights, v); edge; ++edge) {
        const auto j = static_cast<Index>(edge.row());
        energy += edge.value() * (edge_of(positions, j) - rotation * edge_of(rest, j)).squaredNorm();
    }
    return energy;
}

}  // namespace

Positions arap(const Problem& problem, const ArapOptions& options, Execution& execution,
               std::vector<double>* energies) {
    if (options.iterations < 0) throw InvalidInput(message("iterations is ", options.iterations, "; give 0 or more"));
    if (!(options.tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", options.tolerance, "; give a positive number"));
    }
    const Setup setup = set_up(problem, execution);
    execution.begin_stage("solve");
    Positions positions = smooth_start(setup, execution);
    if (setup.unknowns.free.empty()) return positions;
    const EdgeLaplacian laplacian(cotangent_weights(problem, execution), setup.is_fixed, execution);
    const double least_move = options.tolerance * bounding_box_diagonal(problem.vertices);
    const std::vector<Index>& stars = laplacian.stars();
    std::vector<Matrix3> rotations(problem.vertices.rows(), Matrix3::Identity());
    std::vector<double> star_energies(stars.size());
    const auto fit_rotations = [&] {
        parallel_for(static_cast<Index>(stars.size()), setup.threads, execution, [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k) {
                star_energies[k] =
                    fit_star(laplacian.weights(), problem.vertices, positions, stars[k], rotations[stars[k]]);
            }
        });
        if (energies == nullptr) return;
        energies->push_back(std::accumulate(star_energies.begin(), star_energies.end(), 0.0));
    };
    const auto turned_edge = [&](Index i, Eigen::Index j) -> Eigen::RowVector3d {
        return 0.5 * (problem.vertices.row(i) - problem.vertices.row(j)) * (rotations[i] + rotations[j]).transpose();
    };
    fit_rotations();
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
        execution.check();
        execution.set_progress(static_cast<double>(iteration) / options.iterations);
        const double longest_move = laplacian.place(turned_edge, positions, execution);
        fit_rotations();
        if (longest_move <= least_move) break;
    }
    return positions;
}

}  // namespace meanvalue::baselines
