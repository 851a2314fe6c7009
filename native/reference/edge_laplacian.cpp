#include "reference/edge_laplacian.h"

#include <cmath>

#include "meanvalue/common/errors.h"

namespace meanvalue::baselines {
namespace {

using Entry = Eigen::Triplet<double, EdgeWeights::StorageIndex>;

// Below: obtuse triangles would push apart what they should hold. Above: a triangle without area has no cotangent.
constexpr double kLeastWeight = 1e-3;
constexpr double kMostWeight = 1e4;

double half_cotangent(const Vector3& a, const Vector3& b) {
    const double sine = a.cross(b).norm();
    const double cosine = a.dot(b);
    if (sine * kMostWeight > std::abs(cosine)) return 0.5 * cosine / sine;
    return cosine == 0.0 ? 0.0 : std::copysign(kMostWeight, cosine);
}

}  // namespace

EdgeWeights cotangent_weights(const Problem& problem, const Execution& execution) {
    std::vector<Entry> entries;
    entries.reserve(6 * static_cast<std::size_t>(problem.faces.rows()));
    for (Index f = 0; f < problem.faces.rows(); ++f) {
        execution.check_every(f);
        for (int k = 0; k < 3; ++k) {
            const Index a = problem.faces(f, k);
            const Index b = problem.faces(f, (k + 1) % 3);
            const auto apex = problem.vertices.row(problem.faces(f, (k + 2) % 3));
            const double weight = half_cotangent((problem.vertices.row(a) - apex).transpose(),
                                                 (problem.vertices.row(b) - apex).transpose());
            entries.emplace_back(a, b, weight);
            entries.emplace_back(b, a, weight);
        }
    }
    execution.check();
    EdgeWeights weights(problem.vertices.rows(), problem.vertices.rows());
    weights.setFromTriplets(entries.begin(), entries.end());
    weights.coeffs() = weights.coeffs().max(kLeastWeight).min(kMostWeight);
    return weights;
}

EdgeWeights uniform_weights(const Problem& problem, const Execution& execution) {
    EdgeWeights weights = cotangent_weights(problem, execution);
    weights.coeffs() = 1.0;
    return weights;
}

EdgeLaplacian::EdgeLaplacian(const EdgeWeights& weights, const std::vector<char>& is_fixed,
                             const Execution& execution)
    : weights_(weights) {
    std::vector<std::int64_t> number(is_fixed.size(), -1);
    for (Index v = 0; v < weights_.cols(); ++v) {
        if (is_fixed[v]) continue;
        number[v] = static_cast<std::int64_t>(free_.size());
        free_.push_back(v);
    }
    std::vector<Entry> entries;
    for (Index v = 0; v < weights_.cols(); ++v) {
        execution.check_every(v);
        bool matters = number[v] >= 0;
        double sum = 0.0;
        for (EdgeWeights::InnerIterator edge(weights_, v); edge; ++edge) {
            sum += edge.value();
            matters = matters || number[edge.row()] >= 0;
            if (number[v] >= 0 && number[edge.row()] > number[v])
                entries.emplace_back(number[edge.row()], number[v], -edge.value());
        }
        if (number[v] >= 0) entries.emplace_back(number[v], number[v], sum);
        if (matters) stars_.push_back(v);
    }
    if (free_.empty()) return;
    const auto free_count = static_cast<Eigen::Index>(free_.size());
    SparseMatrix lower(free_count, free_count);
    lower.setFromTriplets(entries.begin(), entries.end());
    cholesky_.analyse(lower, execution);
    // Every part has a fixed vertex and every weight is positive: the matrix is positive definite.
    if (!cholesky_.factorise(lower, execution))
        throw SolverFailure(message("the Laplacian of ", free_count, " vertices is not positive definite"));
}

Eigen::MatrixXd EdgeLaplacian::solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const {
    if (free_.empty()) return right_hand_sides;
    Eigen::MatrixXd moves = cholesky_.solve(right_hand_sides, execution);
    if (!moves.allFinite())
        throw SolverFailure(message("the Laplacian of ", free_.size(), " vertices has no finite solution"));
    return moves;
}

}  // namespace meanvalue::baselines
