// Small symmetric positive definite matrices, one for each class that the factorisation must deal with.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "meanvalue/linalg/graph.h"
#include "tests/meshes.h"

namespace meanvalue::tests {

/// Lower triangles, all of them.

/// The sum of squares of what a vertex is apart from the weighted mean of its ring, every tenth vertex held softly.
SparseMatrix bilaplacian(const Mesh& mesh, unsigned seed = 1);
SparseMatrix diagonal(Index size);
/// Every entry of the lower triangle, as a mesh of one very long ring would have.
SparseMatrix full(Index size);
/// The first column has an entry in every row.
SparseMatrix arrow(Index size);
SparseMatrix in_parts(const std::vector<SparseMatrix>& parts);
/// Three unknowns for each: every entry becomes a full block.
SparseMatrix in_blocks(const SparseMatrix& lower);

struct Case {
    std::string name;
    SparseMatrix lower;
};

inline void PrintTo(const Case& item, std::ostream* stream) {
    *stream << item.name;
}

/// One of each class.
std::vector<Case> all_matrices();

}  // namespace meanvalue::tests
