#include "meanvalue/decode/decoder.h"

#include <utility>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/extent.h"
#include "meanvalue/optimise/elimination_order.h"

namespace meanvalue {

std::shared_ptr<const RegionShape> encode_shape(Region region, int threads, Execution& execution,
                                                const std::vector<SharedPositions>& examples, double size_of_point) {
    auto shape = std::make_shared<RegionShape>();
    shape->region = std::move(region);
    shape->region.is_fixed.clear();
    const Region& of = shape->region;
    {
        const StageTimer timer(shape->timings, "encode");
        shape->rings = collect_one_rings(static_cast<Index>(of.vertices.size()), of.faces, execution);
        shape->encoding = encode(shape->rings, of.positions, threads, execution);
        shape->size = mean_diagonal(of.positions, threads, execution);
        if (shape->size == 0.0) shape->size = size_of_point;
    }
    if (!examples.empty()) {
        const StageTimer timer(shape->timings, "examples");
        execution.begin_stage("examples");
        shape->examples.emplace(shape->encoding, of, examples, threads, execution);
    }
    return shape;
}

const std::vector<Index>& Decoder::find_order(int threads, Execution& execution) {
    if (!elimination_order_) {
        const StageTimer timer(bind_timings_, "order");
        execution.begin_stage("order");
        elimination_order_ =
            std::make_shared<const std::vector<Index>>(find_elimination_order(shape_->encoding, threads, execution));
    }
    return *elimination_order_;
}

}  // namespace meanvalue
