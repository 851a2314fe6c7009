// Which patches of the held surface the loose parts of a mesh go along with: found once, at bind.
#pragma once

#include <cstddef>
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

/// The place of vertex v. @param positions n x 3, row by row.
template <typename Scalar>
Vector3 place_of(const Scalar* positions, Index v) {
    const Scalar* place = positions + 3 * static_cast<std::ptrdiff_t>(v);
    return {static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])};
}

/// From the first point on: far from the origin a sum of places would be off by more than a part is large.
template <typename Scalar>
Vector3 weighted_centre(const WeightedPoints& some, const Scalar* positions) {
    if (some.points.empty()) return Vector3::Zero();
    const Vector3 first = place_of(positions, some.points.front());
    Vector3 offset = Vector3::Zero();
    for (std::size_t k = 1; k < some.points.size(); ++k)
        offset += some.weights[k] * (place_of(positions, some.points[k]) - first);
    return first + offset;
}

/// Sum of the lengths of the edges from `middle` to each vertex of [begin, end).
template <typename Scalar>
double star_length(Index middle, const Index* begin, const Index* end, const Scalar* positions) {
    double length = 0.0;
    for (const Index* v = begin; v != end; ++v)
        length += (place_of(positions, *v) - place_of(positions, middle)).norm();
    return length;
}

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
/// @param rest n x 3, its rows one after another; @param components of which something is held. @throws Cancelled.
/// Cost: n log n.
FoundPatches find_patches(const PositionsView& rest, const TrianglesView& faces, const Components& components,
                          const Execution& execution);

}  // namespace meanvalue
