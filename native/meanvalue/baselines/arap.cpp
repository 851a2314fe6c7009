#include "meanvalue/baselines/arap.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "meanvalue/baselines/laplacian.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/linalg/sparse_cholesky.h"

namespace meanvalue::baselines {
namespace {

// Below: obtuse triangles would push apart what they should hold. Above: a triangle without area has no cotangent.
constexpr double kLeastWeight = 1e-3;
constexpr double kMostWeight = 1e4;

/// Every edge from both of its ends, as compressed rows. Read off the faces, not the rings: w_ij = w_ji must hold
/// also where several fans meet.
struct Stars {
    std::vector<Index> offsets;    ///< n + 1
    std::vector<Index> neighbour;  ///< ascending in each row
    std::vector<double> weight;    ///< w_ij
};

double half_cotangent(const Vector3& a, const Vector3& b) {
    const double sine = a.cross(b).norm();
    const double cosine = a.dot(b);
    if (sine * kMostWeight > std::abs(cosine)) return 0.5 * cosine / sine;
    return cosine == 0.0 ? 0.0 : std::copysign(kMostWeight, cosine);
}

Stars cotangent_stars(const Problem& problem, const Execution& execution) {
    struct Spoke {
        Index to;
        double weight;
    };
    const Index vertex_count = static_cast<Index>(problem.vertices.rows());
    std::vector<std::size_t> offsets(vertex_count + 1, 0);
    execution.check();
    for (Index f = 0; f < problem.faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k)
            offsets[problem.faces(f, k) + 1] += 2;
    }
    for (Index v = 0; v < vertex_count; ++v)
        offsets[v + 1] += offsets[v];
    std::vector<Spoke> spokes(offsets.back());
    std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
    for (Index f = 0; f < problem.faces.rows(); ++f) {
        execution.check_every(f);
        for (int k = 0; k < 3; ++k) {
            const Index a = problem.faces(f, k);
            const Index b = problem.faces(f, (k + 1) % 3);
            const auto apex = problem.vertices.row(problem.faces(f, (k + 2) % 3));
            const double weight = half_cotangent((problem.vertices.row(a) - apex).transpose(),
                                                 (problem.vertices.row(b) - apex).transpose());
            spokes[next[a]++] = {b, weight};
            spokes[next[b]++] = {a, weight};
        }
    }
    Stars stars;
    stars.offsets.assign(1, 0);
    for (Index v = 0; v < vertex_count; ++v) {
        execution.check_every(v);
        // Stable, so that both spokes of an edge sum the same numbers in the same order, that of the faces.
        std::stable_sort(spokes.begin() + static_cast<std::ptrdiff_t>(offsets[v]),
                         spokes.begin() + static_cast<std::ptrdiff_t>(offsets[v + 1]),
                         [](const Spoke& x, const Spoke& y) { return x.to < y.to; });
        for (std::size_t k = offsets[v]; k < offsets[v + 1];) {
            const Index to = spokes[k].to;
            double weight = 0.0;
            for (; k < offsets[v + 1] && spokes[k].to == to; ++k)
                weight += spokes[k].weight;
            stars.neighbour.push_back(to);
            stars.weight.push_back(std::clamp(weight, kLeastWeight, kMostWeight));
        }
        stars.offsets.push_back(static_cast<Index>(stars.neighbour.size()));
    }
    return stars;
}

/// The turns of local and global steps; holds what they share.
class LocalGlobal {
  public:
    LocalGlobal(const Problem& problem, const Setup& setup, Execution& execution)
        : rest_(problem.vertices),
          stars_(cotangent_stars(problem, execution)),
          unknowns_(find_unknowns(stars_.offsets, stars_.neighbour, setup.is_fixed)),
          threads_(setup.threads),
          execution_(execution),
          rotations_(problem.vertices.rows(), Matrix3::Identity()) {
        factorise();
    }

    /// R_i of every star with a free vertex. @return the energy with these rotations.
    double fit_rotations(const Positions& positions) {
        const Index row_count = static_cast<Index>(unknowns_.rows.size());
        std::vector<double> energies(row_count);
        parallel_for(row_count, threads_, execution_, [&](Index begin, Index end) {
            for (Index row = begin; row < end; ++row)
                energies[row] = fit_rotation_of(unknowns_.rows[row], positions);
        });
        double sum = 0.0;
        for (const double energy : energies)
            sum += energy;
        return sum;
    }

    /// Moves the free vertices to the minimum for the rotations as they are. @return the longest move.
    double place_vertices(Positions& positions) {
        Eigen::MatrixXd descent(unknowns_.free.size(),
                                3);  // L moves = descent; both sides are the energy's derivatives over four
        for (std::size_t k = 0; k < unknowns_.free.size(); ++k) {
            execution_.check_every(k);
            const Index v = unknowns_.free[k];
            Vector3 sum = Vector3::Zero();
            for (Index e = stars_.offsets[v]; e < stars_.offsets[v + 1]; ++e) {
                const Index j = stars_.neighbour[e];
                const Vector3 turned = 0.5 * (rotations_[v] + rotations_[j]) * spoke(rest_, v, j);
                sum += stars_.weight[e] * (turned - spoke(positions, v, j));
            }
            descent.row(static_cast<Eigen::Index>(k)) = sum.transpose();
        }
        const Eigen::MatrixXd moves = cholesky_.solve(descent, execution_);
        if (!moves.allFinite()) {
            throw SolverFailure(
                message("the Laplacian of ", unknowns_.free.size(), " vertices has no finite solution"));
        }
        for (std::size_t k = 0; k < unknowns_.free.size(); ++k)
            positions.row(unknowns_.free[k]) += moves.row(static_cast<Eigen::Index>(k));
        return moves.rowwise().norm().maxCoeff();
    }

  private:
    static Vector3 spoke(const PositionsView& positions, Index i, Index j) {
        return (positions.row(i) - positions.row(j)).transpose();
    }

    double fit_rotation_of(Index v, const Positions& positions) {
        Matrix3 covariance = Matrix3::Zero();
        for (Index e = stars_.offsets[v]; e < stars_.offsets[v + 1]; ++e) {
            const Index j = stars_.neighbour[e];
            covariance += stars_.weight[e] * spoke(positions, v, j) * spoke(rest_, v, j).transpose();
        }
        rotations_[v] = fit_rotation(covariance);
        double energy = 0.0;
        for (Index e = stars_.offsets[v]; e < stars_.offsets[v + 1]; ++e) {
            const Index j = stars_.neighbour[e];
            energy += stars_.weight[e] * (spoke(positions, v, j) - rotations_[v] * spoke(rest_, v, j)).squaredNorm();
        }
        return energy;
    }

    /// Of free vertex number `column`: its neighbours below the diagonal, by entry(row, weight).
    template <typename Entry>
    void for_each_below(std::int64_t column, const Entry& entry) const {
        const Index v = unknowns_.free[column];
        for (Index e = stars_.offsets[v]; e < stars_.offsets[v + 1]; ++e) {
            const Index slot = unknowns_.slot[stars_.neighbour[e]];  // ascending, as the neighbours are
            if (slot > column) entry(slot, stars_.weight[e]);
        }
    }

    /// The lower triangle, column by column.
    SparseMatrix laplacian() const {
        const std::int64_t free_count = static_cast<std::int64_t>(unknowns_.free.size());
        SparseMatrix lower(free_count, free_count);
        std::int64_t* const outer = lower.outerIndexPtr();
        for (std::int64_t column = 0; column < free_count; ++column) {
            execution_.check_every(column);
            outer[column + 1] = outer[column] + 1;
            for_each_below(column, [&](Index, double) { ++outer[column + 1]; });
        }
        lower.resizeNonZeros(outer[free_count]);
        for (std::int64_t column = 0; column < free_count; ++column) {
            execution_.check_every(column);
            const Index v = unknowns_.free[column];
            std::int64_t place = outer[column];
            lower.innerIndexPtr()[place] = column;
            lower.valuePtr()[place] = std::accumulate(stars_.weight.begin() + stars_.offsets[v],
                                                      stars_.weight.begin() + stars_.offsets[v + 1], 0.0);
            for_each_below(column, [&](Index row, double weight) {
                lower.innerIndexPtr()[++place] = row;
                lower.valuePtr()[place] = -weight;
            });
        }
        return lower;
    }

    /// Every part has a fixed vertex and every weight is positive: the Laplacian is positive definite.
    void factorise() {
        const SparseMatrix lower = laplacian();
        cholesky_.analyse(lower, execution_);
        if (!cholesky_.factorise(lower, execution_)) {
            throw SolverFailure(message("the Laplacian of ", lower.rows(), " vertices is not positive definite"));
        }
    }

    const PositionsView& rest_;
    Stars stars_;
    Unknowns unknowns_;
    int threads_;
    Execution& execution_;
    std::vector<Matrix3> rotations_;  // n
    SparseCholesky cholesky_;
};

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
    LocalGlobal solver(problem, setup, execution);
    const double least_move = options.tolerance * bounding_box_diagonal(problem.vertices);
    const auto fit_rotations = [&] {
        const double energy = solver.fit_rotations(positions);
        if (energies != nullptr) energies->push_back(energy);
    };
    fit_rotations();
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
        execution.check();
        execution.set_progress(static_cast<double>(iteration) / options.iterations);
        const double longest_move = solver.place_vertices(positions);
        fit_rotations();
        if (longest_move <= least_move) break;
    }
    return positions;
}

}  // namespace meanvalue::baselines
