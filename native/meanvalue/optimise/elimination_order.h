// An order of elimination for the unknowns of a mesh, whichever of its vertices are fixed.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// All vertices, in an order that leaves little fill in matrices that couple each two vertices of a row, a vertex and
/// its ring. Without those that are fixed it is an order of the same quality for the others: what separates two parts
/// of a mesh separates what is left of them. So it is found once, for all anchors.
/// @param threads as given by thread_count(); the result is the same for any. @throws Cancelled.
std::vector<Index> find_elimination_order(const Encoding& encoding, int threads, const Execution& execution);

/// The free vertices' numbers in that order. @param order all vertices.
std::vector<Index> numbers_in_order(const std::vector<Index>& order, const Unknowns& unknowns);

}  // namespace meanvalue
