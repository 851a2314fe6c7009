// Which patches of the held surface the loose parts of a mesh go along with: found once, at bind.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// What a loose part is carried by.
struct LoosePatch {
    Vector3 centre = Vector3::Zero();       ///< of the points, weighted, at rest
    std::vector<Index> points;              ///< vertices of the carrier
    std::vector<double> weights;            ///< of these, summing to 1
    std::vector<std::vector<Index>> stars;  ///< some vertices of the carrier around the part, each with neighbours
    std::vector<double> star_lengths;       ///< sum of the edges of each at rest, above 0
};

struct FoundPatches {
    std::vector<Index> carriers;       ///< of each part of the mesh: the part that carries it, or -1
    std::vector<Index> patch_of_part;  ///< or -1
    std::vector<LoosePatch> patches;
};

/// The carrier is the held part with the vertex nearest to the loose one. A patch is made of its vertices nearest to
/// those of the loose part, which count by the fourth power of their nearness, and what is around these where they
/// are few. A loose part inside the box around a larger one, and nearer to that than to what is held (the iris within
/// its eye), has the same patch.
/// @param rest n x 3; @param components of which something is held. @throws Cancelled. Cost: n log n.
FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution);

}  // namespace meanvalue
