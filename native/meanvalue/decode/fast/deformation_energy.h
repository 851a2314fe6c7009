// The energy that the fast method minimises: the paper's, with a term that keeps lengths.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/fast/energy_blocks.h"
#include "meanvalue/decode/fast/energy_kernels.h"
#include "meanvalue/decode/fast/soft_constraints.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The block of a symmetric matrix between free and fixed vertices.
struct FixedCoupling {
    std::vector<Index> vertices;  ///< the fixed vertices that rows of the energy depend on, ascending
    SparseMatrix matrix;          ///< |V'| x |vertices|, one number for each pair
};

/// The matrix that quasi-Newton steps begin with.
struct InitialHessian {
    SparseMatrix matrix;     ///< |V'| x |V'|, one number for each pair of free vertices (lower triangle)
    FixedCoupling coupling;  ///< how the gradient at each free vertex changes with each fixed one
};

/// E = 1/2 sum_i a_i |v_i - F_i(V)|^2
///     + rigidity/2 (h/D)^2 sum_i f_i sum_(j,k) c_jk |(v_j - v_k) - R_i (p_j - p_k)|^2
///     + sum_k s_k |v_k - t_k|^2
///
/// over the rows i that depend on free vertices. The first sum is equation 15 with weights. In the second, (j, k) are
/// the spokes and rims of row i, p is the rest pose, R_i the rotation that fits best, and c the cotangent weights (as
/// rigid as possible: Sorkine and Alexa 2007; with rims: Chao et al. 2010), larger where the rest pose is curved, as
/// thin limbs are. With h_i the mean edge of row i at rest, a_i = h^2 / h_i^2, h^2 making them 1 in the mean, and D
/// the size of the shape: the sums then approximate integrals over the surface of the squared change of curvature,
/// and of squared strain over D^2, at any resolution, and rigidity has no unit. The row of an isolated anchor counts
/// many times more. The third sum is of soft anchors (SoftConstraints). docs/algorithm.md, "Rigidity" and "Soft
/// anchors".
class DeformationEnergy {
  public:
    /// What an evaluation writes besides its result, and the targets of soft constraints: one for each solve that
    /// runs.
    struct Workspace {
        /// What one thread writes.
        struct Scratch {
            std::vector<PaddedPoint> positions;  // of a block
            KernelScratch kernel;
        };
        std::vector<PaddedPoint> shares;   ///< of dE/dV, by each point of each block
        std::vector<double> block_energy;  ///< of E, by each block
        std::vector<Scratch> scratch;
        std::optional<EnergyBlocks> rows;  ///< of refill(), in place of those at rest
        Positions soft_targets;            ///< |soft anchors| x 3: to be set before anything is evaluated
        std::vector<double> soft_weights;  ///< |soft anchors|, what each counts in this solve; empty: 1
    };

    /// @param by_length how far the weights above are taken, from 0 to 1, as their exponent. At 0 all are 1, and with
    /// rigidity 0 E is the paper's G, equation 15; weights_for() says what belongs to a rigidity.
    /// @param cells at rest, of the encoding; @param size D, in the same units. @param soft_constraints or none.
    /// @param stiffness n factors f_i, or empty: 1.
    /// @pre encoding and unknowns outlive it. @throws Cancelled.
    DeformationEnergy(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
                      double by_length, const Execution& execution,
                      InstructionSet instructions = InstructionSet::kFastest, SoftConstraints soft_constraints = {},
                      int threads = 1, const std::vector<double>& stiffness = {});

    /// 1 from rigidity 1 on, and down to 0 with it, so that results do not jump where the paper's energy begins.
    static double weights_for(double rigidity) { return std::min(rigidity, 1.0); }

    /// E in squared units. The same bits for any number of threads. @param positions n x 3.
    /// @param gradient |V'| x 3, receives dE/dV'. @throws Cancelled.
    double evaluate(const PositionsView& positions, double rigidity, Positions& gradient, int threads,
                    const Execution& execution, Workspace& workspace) const;
    Workspace make_workspace() const;

    /// From now on solves with this workspace keep other cells than those at rest. What rows and lengths count stays.
    /// @param encoding, cells of the same layout. The same bits for any number of threads. @throws Cancelled.
    void refill(const Encoding& encoding, const RestCells& cells, int threads, const Execution& execution,
                Workspace& workspace) const;

    /// What of E's Hessian does not depend on the pose: (I - W)^T a (I - W) + rigidity (h/D)^2 times the Laplacian
    /// with weights c. It bounds the second part, whose rotations only lower it, and is the smooth part of the first;
    /// 2 s on the diagonal at soft anchors. The same bits for any number of threads. @throws Cancelled.
    InitialHessian initial_hessian(double rigidity, int threads, const Execution& execution) const;

    const SoftConstraints& soft_constraints() const { return soft_constraints_; }

  private:
    double evaluate_block(const EnergyBlocks& rows, std::size_t block, const PositionsView& positions,
                          double stretching, PaddedPoint* shares, Workspace::Scratch& scratch) const;

    const Encoding& encoding_;
    const Unknowns& unknowns_;
    SoftConstraints soft_constraints_;
    EnergyKernel kernel_;
    EnergyBlocks rows_;
    Grouped<Index> uses_;  // |V'|: where each free vertex' shares are, in the order of the blocks
};

}  // namespace meanvalue
