// What tests ask of a deformed shape.
#pragma once

#include "tests/meshes.h"

namespace meanvalue::tests {

/// Signed volume that the triangles of a closed mesh enclose.
double volume_of(const Positions& shape, const Triangles& faces);

/// How many triangles point against what their surroundings make of their rest normal: the rotations that fit the
/// edges around its corners, averaged, carry it. A fold of one triangle counts, a part that turned as a whole does
/// not.
Index flipped_triangles(const Positions& shape, const Mesh& rest);

/// The largest and the mean length of an edge over its length at rest, less one.
struct Strain {
    double largest = 0.0;
    double mean = 0.0;
};
Strain strain_of(const Positions& shape, const Mesh& rest);

/// The angle about z that turns the vertices `rows` from rest to shape at best, each about their middle.
double turn_about_z(const Positions& shape, const Positions& rest, const std::vector<Index>& rows);

}  // namespace meanvalue::tests
