// Parts of a mesh without a fixed vertex (shirts, eyes, buttons), carried along by what is near to them.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/follow/follower.h"
#include "meanvalue/follow/sheets.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// What a rigid part is carried by.
struct LoosePatch {
    SurfacePatch contact;  ///< where it is moved to: corners of the faces that it touches
    SurfacePatch around;   ///< how it is rotated: these, and what is around them
    RestEdges edges;       ///< how it grows: those at what is around
};

struct FoundPatches {
    std::vector<Index> carriers;       ///< of each part of the mesh: the part that carries it, or -1
    std::vector<char> is_cloth;        ///< of each part
    std::vector<Index> patch_of_part;  ///< of rigid loose ones, or -1
    std::vector<LoosePatch> patches;
};

/// A part is carried by the part with the place nearest to it: of the held ones, and for rigid parts of clothes too.
/// A patch is made of the places that are nearest to vertices of the part, which count by the fourth power of their
/// nearness, and for its rotation of what is around these where they are few. A part inside the box around a larger
/// rigid one, and nearer to that than to held parts (the iris within its eye), has the same patch.
/// @param rest n x 3, its rows one after another; @param components some of them held. @param carrier of these;
/// @param size its mean_diagonal(). @param kind of those that may be clothes. @throws Cancelled. Cost: n log n.
FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const CarrierSurface& carrier, double size, FollowKind kind, const Execution& execution);

/// Makes parts loose that have no fixed vertices but soft anchors flagged in `is_border` (n).
void free_parts_held_by_border(Components& components, const std::vector<char>& is_border);

/// What each loose part goes along with: a function of the shape of that alone, never of where the part was before.
///
/// Clothes bend with the parts that have fixed vertices (Sheets). Others are rigid and go along with a patch of these
/// or of the clothes: a part is rotated as its patch is (best fit), moved as the points of the surface that it
/// touches, and scaled as the surface around it grows. So it keeps its shape, and a similarity of the whole takes it
/// along exactly.
class LooseParts {
  public:
    /// No part is loose.
    LooseParts() = default;

    /// @param rest n x 3. Parts of `components` without a fixed vertex are loose, if another has some.
    /// @param kind of those that may be clothes. The same bits for any `threads`. @throws Cancelled.
    /// Cost: n log n where a part is loose.
    LooseParts(const PositionsView& rest, const TrianglesView& faces, const Components& components, FollowKind kind,
               InstructionSet instructions, int threads, const Execution& execution);

    /// The part that carries each part of the mesh, or -1. Empty where no part is loose.
    const std::vector<Index>& carriers() const { return found_.carriers; }
    /// Whether each part of the mesh is cloth; empty where no part is loose.
    const std::vector<char>& clothes() const { return found_.is_cloth; }

    /// Puts the rows of loose parts where they are carried to.
    /// @param rest as for the constructor; @param positions 3 n numbers, vertex by vertex; other rows are read.
    /// The bits do not depend on `threads`. @throws Cancelled.
    void carry(const PositionsView& rest, double* positions, int threads, const Execution& execution) const;
    void carry(const PositionsView& rest, float* positions, int threads, const Execution& execution) const;

  private:
    FoundPatches found_;
    std::shared_ptr<const Sheets> sheets_;  // or none
    std::vector<Index> vertices_;           // of all patches
    std::vector<Index> patch_of_;           // of each of these
};

}  // namespace meanvalue
