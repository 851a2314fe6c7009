// The energy that the fast method minimises: the paper's, with a term that keeps lengths.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/solver/block_matrix.h"
#include "meanvalue/solver/unknowns.h"

namespace meanvalue {

/// E = 1/2 sum_i a_i |v_i - F_i(V)|^2 + rigidity/2 (h/D)^2 sum_i sum_(j,k) c_jk |(v_j - v_k) - R_i (p_j - p_k)|^2
///
/// over the rows i that depend on free vertices. The first sum is equation 15 with weights. In the second, (j, k) are
/// the spokes and rims of row i, p is the rest pose, R_i the rotation that fits best, and c the cotangent weights (as
/// rigid as possible: Sorkine and Alexa 2007; with rims: Chao et al. 2010). With h_i the mean edge of row i at rest,
/// a_i = h^2 / h_i^2, h^2 making them 1 in the mean, and D the size of the shape: the sums then approximate integrals
/// over the surface of the squared change of curvature, and of squared strain over D^2, at any resolution, and
/// rigidity has no unit. The row of a lone anchor counts many times. docs/algorithm.md, "Rigidity".
class DeformationEnergy {
  public:
    enum class Weights {
        kPlain,    ///< all a_i are 1: with rigidity 0 the paper's G, equation 15
        kByLength  ///< as above
    };

    /// @param rest n x 3; @param size D, in the same units. @pre encoding and unknowns outlive it. @throws Cancelled.
    DeformationEnergy(const Encoding& encoding, const Unknowns& unknowns, const PositionsView& rest, double size,
                      Weights weights, const Execution& execution);

    /// E in squared units. The same bits for any number of threads. @param positions n x 3.
    /// @param gradient |V'| x 3, receives dE/dV'. @throws Cancelled.
    double evaluate(const PositionsView& positions, double rigidity, Positions& gradient, int threads,
                    const Execution& execution);

    /// What of E's Hessian does not depend on the pose, one number for each pair of free vertices (lower triangle):
    /// (I - W)^T a (I - W) + rigidity (h/D)^2 times the Laplacian with weights c. It bounds the second part, whose
    /// rotations only lower it, and is the smooth part of the first. @throws Cancelled.
    SparseMatrix constant_hessian(double rigidity, const Execution& execution) const;

    /// h^2: energies of two resolutions of one shape are as these.
    double resolution() const { return resolution_; }
    std::size_t bytes() const;

  private:
    /// What the second sum needs of one vertex k of a ring of i.
    struct Spoke {
        Vector3 rest;  ///< p_i - p_k
        double spoke;  ///< c_ik
        double rim;    ///< c_kl, l the next in the ring
    };

    void measure(const PositionsView& rest, double size, Weights weights, const Execution& execution);
    /// Whether the row is that of a fixed vertex without fixed neighbours.
    bool is_lone_anchor(std::size_t row) const;
    void index_uses(const Execution& execution);
    void evaluate_row(std::size_t row, const PositionsView& positions, double rigidity);
    void add_rigidity(std::size_t row, const PositionsView& positions, double weight);

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    std::vector<double> bending_;          // a_i, |rows|
    double resolution_ = 0.0;              // h^2
    double stretching_ = 0.0;              // (h/D)^2
    std::vector<std::int64_t> row_start_;  // |rows| + 1: where a row's spokes begin
    std::vector<Spoke> spokes_;
    // Scratch of evaluate(): each row's share of E, and of dE/dV by its ring and by itself.
    std::vector<double> row_energy_;
    std::vector<Vector3> by_ring_;
    std::vector<Vector3> by_centre_;
    // Where each free vertex' shares are: in by_ring_, and the number of its own row or -1.
    std::vector<std::int64_t> use_start_;  // |V'| + 1
    std::vector<std::int64_t> uses_;
    std::vector<Index> own_row_;  // |V'|
};

}  // namespace meanvalue
