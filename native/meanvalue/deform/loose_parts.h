// Parts of a mesh that nothing holds (eyes, teeth, buttons), carried along by the nearest part that something does.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/loose_patches.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// What becomes of parts that neither an anchor nor a fixed vertex holds.
enum class LooseRule {
    kStay,    ///< at rest
    kFollow,  ///< the nearest part that is held
};

/// Parts that nothing holds but soft anchors flagged in `is_resting` (n) become parts that nothing holds.
void let_go(Components& components, const std::vector<char>& is_resting);

/// Which patch of the held surface each loose part goes along with. The place of a part depends on the shape of that
/// patch alone, never on where the part was before.
///
/// A part is turned by the rotation that fits its patch best, moved as the places of the surface that it touches, and
/// grows as the surface around it does: so it keeps its shape, and a similarity of the whole takes it along exactly.
class LooseParts {
  public:
    /// No part is loose.
    LooseParts() = default;

    /// @param rest n x 3. Parts of `components` that nothing holds are loose, if anything else is held.
    /// @throws Cancelled. Cost: that of sorting the vertices, where a part is loose; else that of looking.
    LooseParts(const PositionsView& rest, const TrianglesView& faces, const Components& components,
               const Execution& execution);

    /// Of each part of the mesh: the part that carries it, or -1. Empty where no part is loose.
    const std::vector<Index>& carriers() const { return carriers_; }

    /// Puts the rows of loose parts where they are carried to.
    /// @param rest as for the constructor; @param positions 3 n numbers, vertex by vertex, whose other rows are read.
    /// The bits do not depend on `threads`. @throws Cancelled.
    template <typename Scalar>
    void carry(const PositionsView& rest, Scalar* positions, int threads, const Execution& execution) const;

    /// Of each vertex, how long the edges around it are in some positions; below 0 where that was not asked yet.
    using StarLengths = std::vector<double>;

    /// The same on the calling thread, with the same bits. @param known n lengths in `positions`, which are found
    /// where they are needed: shared by all that carry to these positions along the same faces.
    void carry(const PositionsView& rest, double* positions, StarLengths& known, const Execution& execution) const;

    std::size_t bytes() const;

  private:
    /// Rows of vertices_[begin, end).
    template <typename Scalar>
    void move(Index begin, Index end, const PositionsView& rest, const std::vector<Similarity>& motions,
              Scalar* positions) const;

    std::vector<Index> carriers_;
    std::vector<LoosePatch> patches_;
    std::vector<Index> vertices_;  // all that are carried
    std::vector<Index> patch_of_;  // of each of these
};

}  // namespace meanvalue
