// Which patches of the held surface the loose parts of a mesh go along with: found once, at bind.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Some vertices of a carrier.
struct WeightedPoints {
    std::vector<Index> points;
    std::vector<double> weights;       ///< of these, summing to 1
    Vector3 centre = Vector3::Zero();  ///< of these at rest, weighted
};

/// What a loose part is carried by.
struct LoosePatch {
    WeightedPoints contact;                 ///< where it is moved to: corners of the places that it lies on
    WeightedPoints around;                  ///< how it is turned: these, and what is around them
    std::vector<Index> middles;             ///< some vertices of the carrier around the part
    std::vector<std::vector<Index>> stars;  ///< the neighbours of each of these
    std::vector<double> star_lengths;       ///< sum of the edges from each to them at rest, above 0
};

struct FoundPatches {
    std::vector<Index> carriers;       ///< of each part of the mesh: the part that carries it, or -1
    std::vector<Index> patch_of_part;  ///< or -1
    std::vector<LoosePatch> patches;
};

/// The carrier is the held part with the vertex nearest to the loose one. A patch is made of the places of its faces
/// nearest to vertices of the loose part, which count by the fourth power of their nearness, and for its turn of what
/// is around these where they are few. A loose part inside the box around a larger one, and nearer to that than to
/// what is held (the iris within its eye), has the same patch.
/// @param rest n x 3; @param components of which something is held. @throws Cancelled. Cost: n log n.
FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution);

}  // namespace meanvalue
