// Matrices to factor, as binding a mesh makes them: generated grids, and surfaces read from files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue::benchmarks {

struct Surface {
    Index vertex_count = 0;
    std::vector<std::array<Index, 3>> triangles;
};

/// A triangulated square of side * side vertices.
Surface grid(Index side);
/// @param path .off or .obj; faces of more than three corners are cut into fans. @throws std::runtime_error.
Surface read_surface(const std::string& path);

/// The lower triangle of D^T D, where D takes the difference of each vertex to a randomly weighted mean of its ring;
/// one vertex in twenty is fixed and the rest in random order. About 19 entries a row of the whole matrix.
/// @param block rows and columns of a vertex: each number is multiplied by a positive definite matrix of that size.
SparseMatrix squared_differences(const Surface& surface, Index block);

}  // namespace meanvalue::benchmarks
