// What is checked of numbers that come in from outside.
#pragma once

#include <cstddef>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// @throws InvalidInput unless `name` has one `unit` for each: require_count("targets", 3, "row", 4, "anchors").
void require_count(const char* name, std::size_t size, const char* unit, std::size_t count, const char* of);

/// @param name what the caller calls the array.
/// @throws InvalidInput that names the first row with a coordinate that is not finite.
void require_finite(const PositionsView& positions, const char* name);

/// @param name of the weights that shapes were mixed with. @throws InvalidInput where the mix left the range of
/// double precision.
void require_finite_result(const PositionsView& positions, const char* name);

/// @throws InvalidInput where the bounding box' diagonal is so small or large that its fourth power leaves the range
///         of double precision; one of zero is fine.
void require_moderate_extent(const PositionsView& vertices);

}  // namespace meanvalue
