#include "meanvalue/paper/paper_decoder.h"

#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/optimise/elimination_order.h"
#include "meanvalue/paper/gauss_newton_system.h"

namespace meanvalue {
namespace {

// "About 3 % of the vertices": of the free ones, since in the paper's own table the fixed ones alone are more.
constexpr double kCoarseShare = 0.03;
// "Several Gauss-Seidel iterations, typically four."
constexpr int kSweeps = 4;
constexpr int kMostCoarseSteps = 30;  // the splits that follow undo more than what is left by then

/// The energy where all rows have residuals of `length`.
double energy_of(const Unknowns& unknowns, double length) {
    return 0.5 * static_cast<double>(unknowns.rows.size()) * length * length;
}

std::string describe_end(const DecodeReport& base, const DecodeReport& coarse) {
    if (!base.converged) return message("base mesh: ", base.stop_reason);
    return coarse.converged ? "converged at the coarse level" : coarse.stop_reason;
}

}  // namespace

PaperDecoder::PaperDecoder(EncodedRegion shape, int threads, Execution& execution)
    : Decoder(shape, threads), diagonal_(bounding_box_diagonal(rest_)) {
    fine_ = find_unknowns(encoding_, is_fixed_);
    const StageTimer timer(bind_timings_, "hierarchy");
    CoarseningOptions coarsening;
    coarsening.level_sizes = {static_cast<Index>(std::ceil(kCoarseShare * static_cast<double>(fine_.free.size())))};
    hierarchy_ = build_hierarchy(shape_->rings, rest_, is_fixed_, coarsening, threads_, execution);
    for (const Level& level : hierarchy_.levels)
        splits_.push_back(encode(level.splits.rings, rest_, threads_, execution));
    coarse_unknowns_ = unknowns_of(hierarchy_.levels.front());
    base_unknowns_ = unknowns_of(hierarchy_.base());
}

Unknowns PaperDecoder::unknowns_of(const Level& level) const {
    std::vector<char> is_fixed = is_fixed_;
    for (std::size_t k = 0; k < level.removed_count; ++k)
        is_fixed[hierarchy_.order[k]] = 1;
    return find_unknowns(level.encoding, is_fixed);
}

DecodeReport PaperDecoder::decode(const DecodeOptions& options, Workspace& /*workspace*/, Positions& positions,
                                  Execution& execution) const {
    DecodeReport report;
    execution.begin_stage("solve");
    const int threads = threads_for(options);
    report.energies = {energy(encoding_, fine_, positions, threads, execution)};
    if (!std::isfinite(report.energies.front())) throw SolverFailure("the energy of the start is not finite");
    DecodeReport base;
    {
        const StageTimer timer(report.timings, "base");
        base = solve_base(threads, positions, execution);
    }
    {
        const StageTimer timer(report.timings, "split");
        for (std::size_t level = hierarchy_.levels.size() - 1; level > 0; --level)
            hierarchy_.levels[level].splits.apply(splits_[level], positions, threads, execution);
    }
    {
        const StageTimer timer(report.timings, "optimise");
        const DecodeReport coarse = solve_coarse(options.tolerance, threads, positions, execution);
        report.iterations = coarse.iterations;
        report.initial_gradient = coarse.initial_gradient;
        report.gradient = coarse.gradient;
        report.converged = base.converged && coarse.converged;
        report.stop_reason = describe_end(base, coarse);
    }
    {
        const StageTimer timer(report.timings, "split");
        hierarchy_.levels.front().splits.apply(splits_.front(), positions, threads, execution);
    }
    {
        const StageTimer timer(report.timings, "relax");
        relax(encoding_, fine_, kSweeps, positions, execution);
    }
    report.energies.push_back(energy(encoding_, fine_, positions, threads, execution));
    if (!std::isfinite(report.energies.back()) || !positions.allFinite()) {
        throw SolverFailure(message("the result is not finite; energy of the start: ", report.energies.front()));
    }
    return report;
}

std::vector<Index> PaperDecoder::level_sizes() const {
    std::vector<Index> sizes = {static_cast<Index>(fine_.free.size())};
    for (const Level& level : hierarchy_.levels) {
        sizes.push_back(level.free_count);
    }
    return sizes;
}

DecodeReport PaperDecoder::solve_base(int threads, Positions& positions, Execution& execution) const {
    if (base_unknowns_.free.empty()) return {};
    const Encoding& encoding = hierarchy_.base().encoding;
    choose_start(encoding, base_unknowns_, rest_, is_fixed_, threads, positions, execution);
    MinimiseOptions options;
    options.step_tolerance = kNegligible * diagonal_;
    options.negligible_energy = energy_of(base_unknowns_, kRounding * diagonal_);
    options.threads = threads;
    SparseCholesky cholesky(instructions_);
    return minimise(encoding, base_unknowns_, cholesky, options, positions, execution);
}

DecodeReport PaperDecoder::solve_coarse(double tolerance, int threads, Positions& positions,
                                        Execution& execution) const {
    MinimiseOptions options;
    options.settled_decrease = kSettledPerTolerance * tolerance;
    options.max_iterations = kMostCoarseSteps;
    options.negligible_energy = energy_of(coarse_unknowns_, kRounding * diagonal_);
    options.threads = threads;
    SparseCholesky cholesky(instructions_);
    return minimise(hierarchy_.levels.front().encoding, coarse_unknowns_, cholesky, options, positions, execution);
}

std::size_t PaperDecoder::bytes() const {
    constexpr std::size_t kEachFree = 1100;
    return kEachFree * fine_.free.size();
}

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
