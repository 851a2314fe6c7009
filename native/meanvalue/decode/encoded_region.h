// What every method binds first: a region, its rings and its encoding.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/examples/example_space.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What depends on the shape of a region alone, whatever is fixed in it: everything that is bound to it shares one.
struct RegionShape {
    Region region;  ///< without is_fixed
    OneRings rings;
    Encoding encoding;                      ///< by those rings
    double size = 0.0;                      ///< mean_diagonal()
    std::optional<ExampleShapes> examples;  ///< or none
    Timings timings;                        ///< seconds by stage
};

/// A region with what is fixed in it.
struct EncodedRegion {
    std::shared_ptr<const RegionShape> shape;
    std::vector<char> is_fixed;                              ///< n flags
    InstructionSet instructions = InstructionSet::kFastest;  ///< that it is to be solved with
    Timings timings = {};                                    ///< seconds by stage
    /// The order of elimination of a decoder of this shape with other fixed vertices, or nullptr: one is found.
    std::shared_ptr<const std::vector<Index>> elimination_order = nullptr;
};

/// @param examples of the whole mesh, or none. @param size_of_point what it has where all is in one place.
/// @throws Cancelled. Cost: linear.
std::shared_ptr<const RegionShape> encode_shape(Region region, int threads, Execution& execution,
                                                const std::vector<SharedPositions>& examples = {},
                                                double size_of_point = 1.0);

}  // namespace meanvalue
