// What every baseline is given, and what all of them need to know of it before they start.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue::baselines {

/// One deformation: the same for every method, so that they can be compared.
/// All methods keep anchors at their targets and everything outside the region of influence at rest, exactly, and
/// leave parts without a single fixed vertex where they are. The result is the same for any number of threads.
struct Problem {
    PositionsView vertices;  ///< n x 3 rest positions
    TrianglesView faces;     ///< m x 3
    std::vector<Index> anchors;
    PositionsView targets;                 ///< k x 3, in the order of the anchors
    std::optional<std::vector<char>> roi;  ///< n flags, true may move; none: every vertex may
    int threads = 0;                       ///< 0: every core
};

/// A problem that was checked, with its connectivity.
struct Setup {
    int threads = 1;
    OneRings rings;
    Components components;
    std::vector<char> is_fixed;  ///< n: what is not solved for; parts without a fixed point included
    Unknowns unknowns;           ///< with the one-rings as rows
    Positions carried;           ///< n x 3: each part moved by the similarity that fits its fixed vertices best
                                 ///< (linalg/procrustes.h)
    Positions start;             ///< n x 3: `carried`, but what is not solved for exactly where it belongs
};

/// @throws InvalidInput (sizes, numbers out of range, positions that are not finite, an anchor named twice, ...),
///         Cancelled.
Setup set_up(const Problem& problem, Execution& execution);

}  // namespace meanvalue::baselines
