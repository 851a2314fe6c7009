#include "meanvalue/decode/encoded_region.h"

#include <utility>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/extent.h"

namespace meanvalue {

std::shared_ptr<const RegionShape> encode_shape(Region region, int threads, Execution& execution,
                                                const std::vector<SharedPositions>& examples) {
    auto shape = std::make_shared<RegionShape>();
    shape->region = std::move(region);
    shape->region.is_fixed.clear();
    const Region& of = shape->region;
    {
        const StageTimer timer(shape->timings, "encode");
        shape->rings = collect_one_rings(static_cast<Index>(of.vertices.size()), of.faces, execution);
        shape->encoding = encode(shape->rings, of.positions, threads, execution);
        shape->size = mean_diagonal(of.positions, threads, execution);
    }
    if (!examples.empty()) {
        const StageTimer timer(shape->timings, "examples");
        execution.begin_stage("examples");
        shape->examples.emplace(shape->encoding, of, examples, threads, execution);
    }
    return shape;
}

EncodedRegion with_fixed(std::shared_ptr<const RegionShape> shape, std::vector<char> is_fixed,
                         const std::vector<char>& is_soft, const Execution& execution) {
    EncodedRegion result;
    result.shape = std::move(shape);
    result.encoding = {result.shape, &result.shape->encoding};
    const Region& of = result.shape->region;
    result.region = {of.vertices, of.positions, {}, std::move(is_fixed)};
    result.components = find_components(of.positions, of.faces, result.region.is_fixed, execution, is_soft);
    return result;
}

}  // namespace meanvalue
