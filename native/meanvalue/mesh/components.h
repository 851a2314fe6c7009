// The parts of a mesh, and what the fixed vertices of each part leave undetermined.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/component.h"

namespace meanvalue {

/// All parts of a mesh.
struct Components {
    std::vector<Component> parts;           ///< ordered by their first vertex
    std::vector<Index> part_of;             ///< n: the part of each vertex
    std::vector<std::vector<Index>> fixed;  ///< the fixed vertices and soft anchors of each part, ascending

    bool is_loose(Index part) const { return fixed[part].empty(); }
};

/// Splits the mesh into parts that hang together by triangles; a loose vertex is a part of its own. Parts that share
/// but a single vertex count as one, although that vertex leaves them free to rotate about it.
/// @param positions n x 3 rest positions; @param is_fixed n flags; @param is_soft the same of soft anchors, none of
/// them fixed, or empty. @throws Cancelled. Cost: linear.
Components find_components(const PositionsView& positions, const TrianglesView& faces,
                           const std::vector<char>& is_fixed, const Execution& execution,
                           const std::vector<char>& is_soft = {});

}  // namespace meanvalue
