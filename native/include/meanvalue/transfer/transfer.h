// The shape keys of one mesh on another, of other faces and proportions.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Two meshes at rest, by share(), and which place is which.
struct TransferBinding {
    SharedPositions source_rest;  ///< m x 3
    SharedTriangles source_faces;
    SharedPositions target_rest;  ///< n x 3
    SharedTriangles target_faces;
    std::vector<Index> faces;  ///< n: the face of the source where each vertex of the target is
    Positions weights;         ///< n x 3: of its corners, with the sum 1
    int threads = 0;           ///< 0: every core
};

/// The shapes on the target, n rows each, one after another: offsets turn, grow and stretch as the target does beside
/// the source, what meets there meets here, parts that move rigidly do so here, and what rests there rests.
/// docs/algorithm.md, "Shape keys of another face". The same bits for any number of threads.
/// @param shapes m x 3 each. @param closes one for each shape: whether what meets in it is to meet on the target.
/// @throws InvalidInput that names what is wrong with which array, SolverFailure, Cancelled. Cost: n log n for each.
Positions transfer(const TransferBinding& binding, const std::vector<SharedPositions>& shapes,
                   const std::vector<char>& closes, Execution& execution);

}  // namespace meanvalue
