// What a Binding says of anchors, settings and examples, checked, in the form that decoders take.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "meanvalue/deform/binding.h"

namespace meanvalue {

/// What the method has for it where none is given. @throws InvalidInput.
double rigidity_of(const Binding& binding);

/// @throws InvalidInput for a stiffness of another length, out of range or of another method.
void require_stiffness(const Binding& binding);

/// @param there bytes that there are. @throws TooLittleMemory where a bind of method fast with so many free
/// vertices takes more at its peak.
void require_memory(Index free_count, std::uint64_t there);

/// @param binding with vertices and faces that were checked. @throws InvalidInput that names the example: of another
/// mesh, not finite, of another size, inside out, the rest shape once more, or the same as another one; and for
/// methods that know no examples.
void require_examples(const Binding& binding);

/// An anchor of a region.
struct AnchorOfRegion {
    Index number;
    Index vertex;       ///< there
    Index handle = -1;  ///< or none is given
    double strength = std::numeric_limits<double>::infinity();
};

/// n flags, empty where all anchors are hard. @throws InvalidInput.
std::vector<char> soft_flags(const Binding& binding);

/// n flags: the anchors of a soft border. @throws InvalidInput unless they are soft.
std::vector<char> border_flags(const Binding& binding);

}  // namespace meanvalue
