// Soft constraints: free vertices that springs pull to their targets.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// An anchor that is pulled instead of fixed.
struct SoftAnchor {
    Index vertex = 0;       ///< a free one
    Index anchor = 0;       ///< its place among all anchors, in whose order targets come
    double strength = 1.0;  ///< s > 0, finite, without unit: its spring has the energy s |v - target|^2
};

/// How near to a fixed vertex a soft anchor is, from 0 to 1. Rows of free vertices have diagonals of about 1.
inline double hardness_of(double strength) {
    return strength / (strength + 1.0);
}

/// sum_k s_k |v_k - t_k|^2 over the soft anchors of one level, at any rigidity. The targets t, one row for each in
/// their order, belong to whoever solves.
class SoftConstraints {
  public:
    SoftConstraints() = default;
    /// @param anchors their order does not matter. @pre all of them are free.
    SoftConstraints(std::vector<SoftAnchor> anchors, const Unknowns& unknowns);

    bool empty() const { return anchors_.empty(); }
    const std::vector<Index>& vertices() const { return vertices_; }  ///< ascending

    /// |anchors| x 3. @param targets k x 3, in the order of all anchors, the units of the positions.
    Positions targets_of(const PositionsView& targets) const { return targets(places_, Eigen::all); }
    /// |anchors| numbers. @param weights k, in the order of all anchors.
    std::vector<double> weights_of(const std::vector<double>& weights) const { return picked(weights, places_); }
    /// |anchors| x 3: where the soft anchors are in `positions` (n x 3).
    Positions rows_of(const PositionsView& positions) const { return positions(vertices_, Eigen::all); }

    /// Their energy, in squared units. Adds its derivative to `gradient` (|V'| x 3). @param targets |anchors| x 3.
    /// @param weights |anchors|, what the strength of each is multiplied with; or empty: 1.
    /// The same bits for any number of threads. @throws Cancelled.
    double add_energy(const PositionsView& positions, const Positions& targets, const std::vector<double>& weights,
                      Positions& gradient, int threads, const Execution& execution) const;
    /// |V'| rows of add_hessian(), one for each in order, and what of 2 s does not count with `weights`.
    const std::vector<Index>& rows() const { return numbers_; }
    std::vector<double> lost_hessian(const std::vector<double>& weights) const;
    /// Adds 2 s times the moves of their targets to `fall` (|V'| x 3): by so much the gradient falls.
    /// @param moves of which the last |anchors| rows are theirs. @param weights as for add_energy().
    void add_pulls(const Positions& moves, const std::vector<double>& weights, Positions& fall) const;
    /// Adds 2 s to the diagonal of `hessian`, whose columns begin with it (lower triangle).
    void add_hessian(SparseMatrix& hessian) const;

    /// n numbers: hardness_of() each soft anchor, 0 elsewhere; empty where there are none.
    std::vector<double> hardness(std::size_t vertex_count) const;

  private:
    std::vector<SoftAnchor> anchors_;  // by ascending vertex
    std::vector<Index> vertices_;      // of these
    std::vector<Index> places_;        // among all anchors
    std::vector<Index> numbers_;       // among the free vertices
};

/// Those removed on the way to `level` give their strengths to those that they were merged into, so that a handle's
/// total spring is kept; then all are multiplied with `scale`. @param anchors by ascending vertex, as the result is.
std::vector<SoftAnchor> coarse_soft_anchors(const std::vector<SoftAnchor>& anchors, const Hierarchy& hierarchy,
                                            const Level& level, std::size_t vertex_count, double scale);

/// 1 / mean(1 / h_i^2), squared units, h_i the mean edge of row i at rest: what the energy of a given pose is
/// proportional to, so that springs of two levels are in balance where their strengths are too.
double energy_unit(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells);

}  // namespace meanvalue
