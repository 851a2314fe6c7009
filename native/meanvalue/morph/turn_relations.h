// How parts of a shape are turned against their neighbours, averaged and put together again.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/morph/cell_patches.h"

namespace meanvalue {

/// Averages of rotation vectors turn every cell about an axis of its own in space: a forearm does not bend about the
/// elbow then, but about what is between the axes of elbow and shoulder. Averages of the turns of each part against
/// its neighbours do. Parts are patches of some dozen cells; the rotations of all patches are found that agree best
/// with the average turns between neighbours (least squares, by Gauss and Newton), and what they differ by from the
/// averages in space goes smoothly over to the cells. docs/algorithm.md, "Blending".
class TurnRelations {
  public:
    /// @param layout the rings, n. @param turns n x k rotation vectors, vertex after vertex: TurnedCells.
    /// @pre layout outlives it. @throws Cancelled, SolverFailure. Cost: linear.
    TurnRelations(const Encoding& layout, const std::vector<Vector3>& turns, Index shape_count,
                  const Execution& execution);

    /// Corrects averages in space. Where one shape has all the weight nothing changes.
    /// @param frames as of TurnedCells::fill_rotations(). @param rotations n, of the cells. The same bits for any
    /// `threads`. @throws Cancelled.
    void correct(const ShapeWeights& weights, const std::vector<Matrix3>& frames, int threads,
                 const Execution& execution, std::vector<Matrix3>& rotations) const;

    std::size_t bytes() const;

  private:
    struct Pair {
        Index a;
        Index b;
        double weight;  // mesh edges between them
    };
    struct Step {
        Index patch;
        Index from;        // itself, where a part of the mesh begins
        std::size_t pair;  // of both
    };

    void relate(const std::vector<Vector3>& turns, const Execution& execution);
    void factorise(const Execution& execution);
    void connect(const Execution& execution);
    std::vector<double> weights_of_patches(const ShapeWeights& weights) const;
    std::vector<Matrix3> follow(const std::vector<Matrix3>& between, const std::vector<Matrix3>& in_space) const;
    double step(const std::vector<Matrix3>& between, std::vector<Matrix3>& rotations,
                const Execution& execution) const;

    const Encoding& layout_;
    Index shape_count_;
    CellPatches patches_;
    Index patch_count_;
    std::vector<Vector3> turns_;     // patches x k
    std::vector<Pair> pairs_;        // a < b, ascending
    std::vector<Vector3> relative_;  // pairs x k: of b against a, in the frame of a
    std::vector<Step> tree_;         // every patch once, after the one that it is reached from
    SupernodalFactor factor_;
};

}  // namespace meanvalue
