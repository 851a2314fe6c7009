// Parts of a mesh without a fixed vertex (eyes, teeth, buttons), carried along by the nearest part that has some.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/loose_patches.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Makes parts loose that have no fixed vertices but soft anchors flagged in `is_border` (n).
void free_parts_held_by_border(Components& components, const std::vector<char>& is_border);

/// Which patch of the surface each loose part goes along with. Where it is depends on the shape of that patch alone,
/// never on where the part was before.
///
/// A part is rotated as its patch is (best fit), moved as the points of the surface that it touches, and scaled as
/// the surface around it grows: so it keeps its shape, and a similarity of the whole takes it along exactly.
class LooseParts {
  public:
    /// No part is loose.
    LooseParts() = default;

    /// @param rest n x 3. Parts of `components` without a fixed vertex are loose, if another has some.
    /// @throws Cancelled. Cost: n log n where a part is loose.
    LooseParts(const PositionsView& rest, const TrianglesView& faces, const Components& components,
               const Execution& execution);

    /// The part that carries each part of the mesh, or -1. Empty where no part is loose.
    const std::vector<Index>& carriers() const { return carriers_; }

    /// Puts the rows of loose parts where they are carried to.
    /// @param rest as for the constructor; @param positions 3 n numbers, vertex by vertex; other rows are read.
    /// The bits do not depend on `threads`. @throws Cancelled.
    template <typename Scalar>
    void carry(const PositionsView& rest, Scalar* positions, int threads, const Execution& execution) const;

  private:
    std::vector<Index> carriers_;
    std::vector<LoosePatch> patches_;
    std::vector<Index> vertices_;  // all that are carried
    std::vector<Index> patch_of_;  // of each of these
};

}  // namespace meanvalue
