// What a Binding says of anchors and settings, checked, in the form that decoders take.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/decode/fast/soft_constraints.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What the method has for it where none is given. @throws InvalidInput.
double rigidity_of(const Binding& binding);

/// @throws InvalidInput for a stiffness of another length, out of range or of another method.
void require_stiffness(const Binding& binding);

/// @param there bytes that there are. @throws TooLittleMemory where a bind of method fast with so many free
/// vertices takes more at its peak.
void require_memory(Index free_count, std::uint64_t there);

/// The handle of each vertex of the region that is an anchor, -1 for the others; empty where none are given.
/// @throws InvalidInput.
std::vector<Index> handles_of_region(const Binding& binding, const Region& region);

/// n flags, empty where all anchors are hard. @throws InvalidInput.
std::vector<char> soft_flags(const Binding& binding);

/// n flags: the anchors of a soft border. @throws InvalidInput unless they are soft.
std::vector<char> border_flags(const Binding& binding);

/// In the region's vertex numbers. @param is_soft soft_flags().
std::vector<SoftAnchor> soft_anchors_of_region(const Binding& binding, const std::vector<char>& is_soft,
                                               const Region& region);

}  // namespace meanvalue
