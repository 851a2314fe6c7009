// The parts of a mesh, and what the fixed vertices of each part leave undetermined.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// One connected part of a mesh.
struct Component {
    Index vertex_count = 0;
    Index free_count = 0;
    Index fixed_count = 0;
    Index soft_count = 0;  ///< of the free ones: soft anchors
    /// Degrees of freedom of a similarity that the fixed points and soft anchors leave open: 7 without any, 4 with
    /// one, 1 with two or with collinear ones, 0 with three that are not collinear.
    int undetermined = 7;
    Index first_vertex = 0;  ///< the lowest vertex number in it, to name it by
};

/// All parts of a mesh.
struct Components {
    std::vector<Component> parts;           ///< ordered by their first vertex
    std::vector<Index> part_of;             ///< n: the part of each vertex
    std::vector<std::vector<Index>> fixed;  ///< what holds each part: its fixed vertices and soft anchors, ascending
};

/// Splits the mesh into parts that hang together by triangles; a loose vertex is a part of its own. Parts that share
/// but a single vertex count as one, although that vertex leaves them free to turn about it.
/// @param positions n x 3 rest positions; @param is_fixed n flags; @param is_soft the same of soft anchors, none of
/// them fixed, or empty. @throws Cancelled. Cost: linear.
Components find_components(const PositionsView& positions, const TrianglesView& faces,
                           const std::vector<char>& is_fixed, const Execution& execution,
                           const std::vector<char>& is_soft = {});

}  // namespace meanvalue
