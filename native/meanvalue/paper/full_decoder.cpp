#include "meanvalue/paper/full_decoder.h"

#include "meanvalue/common/tolerances.h"
#include "meanvalue/optimise/elimination_order.h"
#include "meanvalue/paper/gauss_newton_system.h"

namespace meanvalue {

std::size_t FullDecoder::bytes() const {
    constexpr std::size_t kEachFree = 6800;
    return kEachFree * unknowns_.free.size() + analysed_.bytes();
}

FullDecoder::FullDecoder(EncodedRegion shape, int threads, Execution& execution)
    : Decoder(shape, threads), diagonal_(bounding_box_diagonal(rest_)), analysed_(instructions_) {
    const std::vector<Index>& order = find_order(threads_, execution);
    execution.begin_stage("analyse");
    const StageTimer timer(bind_timings_, "analyse");
    unknowns_ = find_unknowns(encoding_, is_fixed_);
    if (unknowns_.free.empty()) return;
    std::vector<Index> columns;
    for (const Index number : numbers_in_order(order, unknowns_)) {
        for (Index c = 0; c < 3; ++c)
            columns.push_back(3 * number + c);
    }
    analysed_.analyse(smoothness_metric(encoding_, unknowns_, execution), execution, threads_, columns);
}

DecodeReport FullDecoder::decode(const DecodeOptions& options, Workspace& /*workspace*/, Positions& positions,
                                 Execution& execution) const {
    SparseCholesky cholesky = analysed_.with_same_pattern();
    MinimiseOptions minimise_options;
    minimise_options.step_tolerance = options.tolerance * diagonal_;
    minimise_options.settled_decrease = kSettledPerTolerance * options.tolerance;
    minimise_options.negligible_energy =
        0.5 * static_cast<double>(unknowns_.rows.size()) * (kRounding * diagonal_) * (kRounding * diagonal_);
    minimise_options.max_iterations = options.max_iterations;
    minimise_options.threads = threads_for(options);
    if (options.previous != nullptr)
        minimise_options.negligible_energy = std::max(minimise_options.negligible_energy, options.enough_energy);
    if (options.previous == nullptr)
        choose_start(encoding_, unknowns_, rest_, is_fixed_, minimise_options.threads, positions, execution);
    return minimise(encoding_, unknowns_, cholesky, minimise_options, positions, execution);
}

}  // namespace meanvalue
