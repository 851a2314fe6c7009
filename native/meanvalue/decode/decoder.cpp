#include "meanvalue/decode/decoder.h"

#include "meanvalue/optimise/elimination_order.h"

namespace meanvalue {

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
