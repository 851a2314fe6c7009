// Carrying each part of a mesh along with its fixed vertices.
#pragma once

#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// Each part of the rest shape moved by the similarity that fits best what holds it (Components::fixed); parts
/// without any such vertex stay.
/// @param rest n x 3; @param placed n x 3, of which the rows of those are read. @param weights n, what each of them
/// counts, above 0; or empty: all the same. @return n x 3.
Positions carry_parts(const Components& components, const PositionsView& rest, const PositionsView& placed,
                      const std::vector<double>& weights = {});

}  // namespace meanvalue
