// Cells of a mesh in patches, and averages of the rotations of these against their neighbors.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/encoding/shape_weights.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {

/// Connected patches of some dozen vertices that have a ring, and how much each vertex belongs to those around it.
struct CellPatches {
    struct Share {
        Index patch;
        double share;
    };

    /// @throws Cancelled. Cost: linear, in rounds that grow with the square root of the vertices in a patch.
    CellPatches(const OneRings& rings, const Execution& execution);

    Index count() const { return static_cast<Index>(sizes.size()); }

    /// The average of the rotations of the patches around a vertex, by their shares. @param rotations one for each
    /// patch, `stride` apart.
    Quaternion mean_rotation(Index vertex, const Quaternion* rotations, std::size_t stride) const;
    /// patches x k: the average weights of their vertices.
    std::vector<double> mean_weights(const ShapeWeights& weights) const;

    std::vector<Index> of;     ///< n: -1 for vertices without a ring
    std::vector<Index> sizes;  ///< in vertices
    Grouped<Share> shares;     ///< of patches in each cell, which sum to 1

  private:
    void grow(const OneRings& rings, const Execution& execution);
    void spread(const OneRings& rings, const Execution& execution);
};

/// Averages of rotation vectors rotate every cell about an axis of its own in space: a forearm does not bend about
/// the elbow then, but about what is between the axes of elbow and shoulder. Averages of the rotations of each patch
/// against its neighbors do. Each cell is rotated against the patches around it, which go smoothly over into each
/// other. Such rotations are small, so that none of them is ambiguous, however far a limb is bent in all. In between,
/// the rotations of all patches are found that agree best with the average rotations between neighbors (least
/// squares, by Gauss and Newton), and the cells' own rotations are averaged on top. docs/algorithm.md, "Blending".
class RelativeRotations {
  public:
    /// @param rotations n x k, vertex after vertex, of cells: LocalCells. What is left of them is how each is rotated
    /// against its mean over all shapes. @param shape_rotations k; each receives the rotation of its shape as a
    /// whole. The same bits for any `threads`. @pre rings outlive it. @throws Cancelled, SolverFailure. Cost: linear.
    RelativeRotations(const OneRings& rings, std::vector<Quaternion>& rotations,
                      std::vector<Quaternion>& shape_rotations, int threads, const Execution& execution);

    /// The rotations of all cells in between. Where one shape has all the weight they are its own.
    /// @param frames, rotation as of LocalCells::fill(). @param rotations receives n. The same bits for any
    /// `threads`.
    /// @throws Cancelled.
    void fill(const ShapeWeights& weights, const std::vector<Quaternion>& frames, const Quaternion& rotation,
              int threads, const Execution& execution, std::vector<Quaternion>& rotations) const;

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

    void find_pairs(const Execution& execution);
    void average_patches(const std::vector<Quaternion>& rotations, const Execution& execution);
    void centre(std::vector<Quaternion>& rotations);
    void rotate_against_patches(const std::vector<Quaternion>& rotations, int threads, const Execution& execution);
    void connect(const Execution& execution);
    std::vector<Quaternion> find_patches_between(const std::vector<double>& shares,
                                                 const std::vector<Quaternion>& frames,
                                                 const Execution& execution) const;
    void step(const std::vector<Quaternion>& between, std::vector<Quaternion>& rotations,
              const Execution& execution) const;
    Quaternion own_weights(Index vertex, const double* weights, const std::vector<double>& shares,
                           const std::vector<Quaternion>& frames, const Quaternion& mean) const;

    const OneRings& rings_;
    std::size_t count_;  // of shapes
    CellPatches patches_;
    Index patch_count_;
    std::vector<Quaternion> means_;       // patches x k: the mean rotations of patches, in space
    std::vector<Vector3> patch_vectors_;  // the same as rotation vectors, each on the branch of its neighbors
    std::vector<Vector3> own_vectors_;    // n x k: of cells against the mean of their patches, in its frame
    std::vector<Pair> pairs_;             // a < b, ascending
    std::vector<Vector3> relative_;       // pairs x k: of b against a, in the frame of a
    std::vector<Step> tree_;              // every patch once, after the one that it is reached from
    std::vector<Index> starts_;           // of each patch: where the part of the mesh begins that it is of
    SupernodalFactor factor_;
};

}  // namespace meanvalue
