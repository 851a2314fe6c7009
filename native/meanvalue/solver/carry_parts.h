// Carrying each part of a mesh along with its fixed vertices.
#pragma once

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Each part of the rest shape moved by the similarity that fits its fixed vertices best; parts without any stay.
/// @param rest n x 3; @param placed n x 3, of which the fixed vertices' rows are read. @return n x 3.
Positions carry_parts(const Components& components, const PositionsView& rest, const PositionsView& placed);

}  // namespace meanvalue
