// Which patches of the surface the loose parts of a mesh go along with: found once, at bind.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Some vertices of a carrier.
struct WeightedPoints {
    std::vector<Index> points;
    std::vector<double> weights;       ///< of these, summing to 1
    Vector3 centre = Vector3::Zero();  ///< of these at rest, weighted
};

/// From the first point on: far from the origin a sum of positions would be off by more than a part is large.
template <typename Scalar>
Vector3 weighted_centre(const WeightedPoints& some, const Scalar* positions) {
    if (some.points.empty()) return Vector3::Zero();
    const Vector3 first = point_at(positions, some.points.front());
    Vector3 offset = Vector3::Zero();
    for (std::size_t k = 1; k < some.points.size(); ++k)
        offset += some.weights[k] * (point_at(positions, some.points[k]) - first);
    return first + offset;
}

/// What a loose part is carried by.
struct LoosePatch {
    WeightedPoints contact;                   ///< where it is moved to: corners of the faces that it touches
    WeightedPoints around;                    ///< how it is rotated: these, and what is around them
    std::vector<std::array<Index, 2>> edges;  ///< how it grows: those at what is around
    std::vector<double> lengths;              ///< of these at rest, above 0
};

struct FoundPatches {
    std::vector<Index> carriers;       ///< of each part of the mesh: the part that carries it, or -1
    std::vector<Index> patch_of_part;  ///< or -1
    std::vector<Index> containers;     ///< of each part: the loose part that it is inside of, or -1
    std::vector<LoosePatch> patches;
};

/// The carrier is the fixed part with the vertex nearest to the loose one. A patch is made of the points of its faces
/// that are nearest to vertices of the loose part, which count by the fourth power of their nearness, and for its
/// rotation of what is around these where they are few. A loose part inside the box around a larger one, and nearer
/// to that than to the fixed parts (the iris within its eye), has the same patch.
/// @param rest n x 3, its rows one after another; @param components at least one of them fixed. @throws Cancelled.
/// Cost: n log n.
FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution);

}  // namespace meanvalue
