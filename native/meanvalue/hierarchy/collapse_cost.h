// What removing a vertex by a half-edge collapse costs the shape: paper, section 3.1.
#pragma once

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/triangle_mesh.h"

namespace meanvalue {

/// The cost of merging `from` into ring vertex `to`, lower is better; docs/algorithm.md, "Collapse cost". The paper
/// names its parts, volume preservation (Lindstrom and Turk) and minimal-angle maximisation, and gives no formula.
/// @param fan the triangles at `from`. Linear in its length.
double collapse_cost(const PositionsView& positions, Index from, Index to, const Fan& fan);

// Collapses that turn a triangle over or leave a needle are put off until nothing better is left.
constexpr double kPutOff = 1e6;

}  // namespace meanvalue
