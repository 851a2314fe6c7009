// What every method binds first: a region, its rings and its encoding.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

struct EncodedRegion {
    Region region;
    Components components;
    OneRings rings;
    Encoding encoding;  ///< by those rings: of the region's own shape, or of another one of the same mesh
    InstructionSet instructions = InstructionSet::kFastest;  ///< that it is to be solved with
    Index detached_triangle_count = 0;                       ///< see TriangleMesh
    Timings timings;                                         ///< seconds by stage
};

/// @param is_soft n flags of soft anchors, or empty. @throws Cancelled. Cost: linear.
EncodedRegion encode_region(Region region, const std::vector<char>& is_soft, int threads, Execution& execution);

}  // namespace meanvalue
