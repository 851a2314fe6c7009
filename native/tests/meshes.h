// Small analytic meshes, one for each class of input that the core must deal with.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue::tests {

constexpr double kPi = 3.14159265358979323846;

struct Mesh {
    std::string name;
    Positions vertices;
    Triangles faces;

    Index vertex_count() const { return static_cast<Index>(vertices.rows()); }
    double diagonal() const;
};

/// So that GoogleTest names a parameter instead of dumping its bytes.
inline void PrintTo(const Mesh& mesh, std::ostream* stream) {
    *stream << mesh.name;
}

/// One triangle, then a strip of two: what spans no plane, and the least that does.
Mesh triangle();
Mesh strip();
/// columns x rows vertices in the plane z = 0, lifted by height * x * y; open, with straight boundaries.
Mesh grid(Index columns, Index rows, double height);
/// n flags: the vertices of a grid that are `margin` or more edges from its border.
std::vector<char> inside_grid(Index columns, Index rows, Index margin);
/// Closed torus of genus 1.
Mesh torus(Index around, Index across);
/// Closed tube along z with a cap of one fan at each end, whose middle has the valence `around`.
Mesh capped_tube(Index around, Index along, double length);
/// Closed bar along z with a unit square for its section, `across` edges wide and `along` such edges long.
Mesh bar(Index across, Index along);
/// A closed convex octahedron subdivided `levels` times.
Mesh sphere(int levels);
/// A grid squeezed to needles: triangles 1000 times as long as wide, and bumpy.
Mesh needles();
/// A closed fan: vertex 0 in the middle of `valence` ring vertices, with random radii and heights.
Mesh random_fan(Index valence, unsigned seed);

/// Adds to every coordinate a normal deviate of the given share of the shortest edge.
Mesh with_noise(Mesh mesh, double share, unsigned seed);
/// Two meshes in one, not connected.
Mesh joined(const Mesh& a, const Mesh& b);

/// One of each class: closed, open, torus, noisy, valence-2 corner, grid boundary, needles, high valence.
std::vector<Mesh> all_classes();

/// Row by row scale * rotation * v + translation.
Positions moved_by_similarity(const Positions& vertices, double scale, const Vector3& axis, double angle_rad,
                              const Vector3& translation);

/// `count` vertices far from each other, beginning at vertex 0 (farthest-point sampling).
std::vector<Index> spread_vertices(const Mesh& mesh, Index count);

/// One for each of `count` vertices: 1 for those in `set`.
std::vector<char> flags(Index count, const std::vector<Index>& set);

/// Rows of `vertices`, in the order of `rows`.
Positions rows_of(const Positions& vertices, const std::vector<Index>& rows);

}  // namespace meanvalue::tests
