// The edges of a mesh with weights, and the system sum_j w_ij (x_i - x_j) = b_i over its free vertices.
#pragma once

#include <vector>

#include "meanvalue/linalg/supernodal_factor.h"
#include "reference/problem.h"

namespace meanvalue::baselines {

/// w_ij for every edge, both ways: n x n, symmetric, nothing on the diagonal. Read off the faces and not the rings,
/// so that w_ij = w_ji also where several fans meet.
using EdgeWeights = SparseMatrix;

/// Half the cotangents across each edge, kept positive and finite. @throws Cancelled.
EdgeWeights cotangent_weights(const Problem& problem, const Execution& execution);
/// The same edges, each with the weight 1. @throws Cancelled.
EdgeWeights uniform_weights(const Problem& problem, const Execution& execution);

/// The system, factored.
class EdgeLaplacian {
  public:
    /// @param is_fixed n flags, of at least one vertex in each part. @throws SolverFailure, Cancelled.
    EdgeLaplacian(const EdgeWeights& weights, const std::vector<char>& is_fixed, const Execution& execution);

    const EdgeWeights& weights() const { return weights_; }
    /// Which end of an edge is free, ascending: all vertices whose star matters.
    const std::vector<Index>& stars() const { return stars_; }

    /// The minimum of sum_ij w_ij |x_i - x_j - wanted(i, j)|^2 over the free rows of x; wanted(i, j) = -wanted(j, i).
    /// @param values n rows, any number of columns. @return the longest move of a row.
    template <typename Values, typename Wanted>
    double place(const Wanted& wanted, Values& values, const Execution& execution) const {
        Eigen::MatrixXd descent(free_.size(), values.cols());
        for (std::size_t k = 0; k < free_.size(); ++k) {
            execution.check_every(k);
            const Index i = free_[k];
            Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(values.cols());
            for (EdgeWeights::InnerIterator edge(weights_, i); edge; ++edge)
                sum += edge.value() * (wanted(i, edge.row()) - (values.row(i) - values.row(edge.row())));
            descent.row(static_cast<Eigen::Index>(k)) = sum;
        }
        const Eigen::MatrixXd moves = solve(descent, execution);
        for (std::size_t k = 0; k < free_.size(); ++k)
            values.row(free_[k]) += moves.row(static_cast<Eigen::Index>(k));
        return free_.empty() ? 0.0 : moves.rowwise().norm().maxCoeff();
    }

  private:
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const;

    EdgeWeights weights_;
    std::vector<Index> free_;
    std::vector<Index> stars_;
    SparseCholesky cholesky_;
};

}  // namespace meanvalue::baselines
