// What a Binding says of examples, checked.
#pragma once

#include "meanvalue/deform/binding.h"

namespace meanvalue {

/// @param binding with vertices and faces that were checked. @throws InvalidInput that names the example: of another
/// mesh, not finite, of another size, inside out, the rest shape once more, or the same as another one; and for
/// methods that know no examples.
void require_examples(const Binding& binding);

}  // namespace meanvalue
