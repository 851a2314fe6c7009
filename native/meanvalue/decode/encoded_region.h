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
#include "meanvalue/examples/example_shapes.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What depends on the shape of a region alone, whatever is fixed in it: everything that is bound to it shares one.
struct RegionShape {
    Region region;  ///< without is_fixed
    OneRings rings;
    Encoding encoding;                      ///< by those rings
    double size = 0.0;                      ///< mean_diagonal()
    std::vector<Index> elimination_order;   ///< or empty: for methods that have no use for it
    std::optional<ExampleShapes> examples;  ///< or none
    Timings timings;                        ///< seconds by stage
};

/// A region with what is fixed in it.
struct EncodedRegion {
    Region region;
    Components components;
    std::shared_ptr<const RegionShape> shape = std::make_shared<const RegionShape>();
    /// By the rings of the shape: its own, or that of another shape of the same mesh.
    std::shared_ptr<const Encoding> encoding{shape, &shape->encoding};
    InstructionSet instructions = InstructionSet::kFastest;  ///< that it is to be solved with
    Timings timings;                                         ///< seconds by stage
    /// The removals of a region of this shape with other fixed vertices, or nullptr: new ones are found along them.
    std::shared_ptr<const RemovalLog> earlier_removals;
};

/// @param has_order whether the method has use for an order of elimination. @param examples of the whole mesh, or
/// none. @throws Cancelled. Cost: linear, but with an order of elimination that of a nested dissection.
std::shared_ptr<const RegionShape> encode_shape(Region region, bool has_order, int threads, Execution& execution,
                                                const std::vector<SharedPositions>& examples = {});

/// @param is_fixed n flags, @param is_soft n flags of soft anchors, or empty. @throws Cancelled. Cost: linear.
EncodedRegion with_fixed(std::shared_ptr<const RegionShape> shape, std::vector<char> is_fixed,
                         const std::vector<char>& is_soft, const Execution& execution);

}  // namespace meanvalue
