// Faces with any number of corners, for who has no triangles.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue::bindings {

/// p faces, counter-clockwise seen from outside.
struct Polygons {
    std::vector<Index> offsets;  ///< p + 1, ascending from 0: face i has the corners offsets[i] to offsets[i + 1] - 1
    std::vector<Index> corners;  ///< vertex numbers
};

struct Triangulation {
    Triangles triangles;          ///< face after face
    std::vector<Index> polygons;  ///< the face that each triangle is a part of
};

/// The triangles that Blender shows of such faces: quads by their first diagonal, unless the halves turn away from
/// each other there; larger faces by cutting ears in the plane of their mean normal.
/// @throws InvalidInput for offsets that do not fit, faces of fewer than three corners, and vertices that are not
/// there.
Triangulation triangulate(const PositionsView& vertices, const Polygons& polygons);

}  // namespace meanvalue::bindings
