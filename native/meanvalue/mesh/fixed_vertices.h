// Which vertices of a mesh may not be moved by a solve, and what is checked of the anchors that say so.
#pragma once

#include <optional>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// n flags: anchors, and what lies outside the region of influence.
/// @param roi n flags, true may move; none: every vertex may.
/// @throws InvalidInput for an anchor outside the mesh or named twice, and for a roi of another size.
std::vector<char> fixed_flags(Index vertex_count, const std::vector<Index>& anchors,
                              const std::optional<std::vector<char>>& roi);

/// Farther from its place at rest, in diagonals of the rest shape, no vertex may be put: the digits that are left for
/// the shape do not tell a minimum from rounding.
constexpr double kFarthestDiagonals = 1e6;

/// @param rest n x 3; @param diagonal of its bounding box. @throws InvalidInput unless `targets` has one finite row
/// for each anchor, none of them farther than kFarthestDiagonals from where its anchor rests.
void require_targets(const PositionsView& targets, const std::vector<Index>& anchors, const PositionsView& rest,
                     double diagonal);

/// The same of a shape to start from, n x 3, for the vertices that are not fixed, ten times as far: what follows
/// targets at the limit may overshoot. @throws InvalidInput.
void require_start(const PositionsView& start, const PositionsView& rest, double diagonal,
                   const std::vector<char>& is_fixed);

}  // namespace meanvalue
