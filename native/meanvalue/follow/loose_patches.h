// What the loose parts of a mesh are, cloth or rigid, and which patches of a surface the rigid ones go along with:
// found once, at bind.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/follow/follower.h"
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

}  // namespace meanvalue
