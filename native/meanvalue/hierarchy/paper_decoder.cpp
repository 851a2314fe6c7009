#include "meanvalue/hierarchy/paper_decoder.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/solver/carry_parts.h"
#include "meanvalue/solver/levenberg_marquardt.h"
#include "meanvalue/solver/sparse_cholesky.h"

namespace meanvalue {
namespace {

// "About 3 % of the vertices": of the free ones, since in the paper's own table the fixed ones alone are more.
constexpr double kCoarseShare = 0.03;
// "Several Gauss-Seidel iterations, typically four."
constexpr int kSweeps = 4;
// The base mesh is solved to this share of the diagonal.
constexpr double kBaseTolerance = 1e-9;

}  // namespace

PaperDecoder::PaperDecoder(Region region, int threads, Execution& execution)
    : region_(std::move(region)), threads_(threads) {
    components_ = find_components(region_.positions, region_.faces, region_.is_fixed);
    const TriangleMesh mesh(static_cast<Index>(region_.vertices.size()), region_.faces, execution);
    detached_triangle_count_ = mesh.detached_count();
    OneRings rings;
    {
        const StageTimer timer(bind_timings_, "encode");
        rings = collect_one_rings(mesh, execution);
        encoding_ = encode(rings, region_.positions, threads_, execution);
        fine_ = find_unknowns(encoding_, region_.is_fixed);
        relaxation_.emplace(encoding_, fine_, execution);
    }
    const StageTimer timer(bind_timings_, "hierarchy");
    CoarseningOptions coarsening;
    coarsening.level_sizes = {static_cast<Index>(std::ceil(kCoarseShare * static_cast<double>(fine_.free.size())))};
    hierarchy_ = build_hierarchy(rings, region_.positions, region_.is_fixed, coarsening, threads_, execution);
    coarse_unknowns_ = unknowns_of(hierarchy_.levels.front());
    coarse_.emplace(hierarchy_.levels.front().encoding, coarse_unknowns_, execution);
    coarse_minimiser_.emplace(*coarse_, coarse_unknowns_, execution);
    base_unknowns_ = unknowns_of(hierarchy_.base());
    base_.emplace(hierarchy_.base().encoding, base_unknowns_, execution);
}

Unknowns PaperDecoder::unknowns_of(const Level& level) const {
    std::vector<char> is_fixed = region_.is_fixed;
    for (std::size_t k = 0; k < level.removed_count; ++k)
        is_fixed[hierarchy_.order[k]] = 1;
    return find_unknowns(level.encoding, is_fixed);
}

DecodeReport PaperDecoder::decode(const DecodeOptions&, Positions& positions, Execution& execution) {
    DecodeReport report;
    execution.begin_stage("solve");
    report.energies = {fine_energy(positions)};
    {
        const StageTimer timer(report.timings, "base");
        solve_base(positions, execution);
    }
    {
        const StageTimer timer(report.timings, "split");
        hierarchy_.split(static_cast<int>(hierarchy_.levels.size()) - 1, 0, positions, threads_, execution);
    }
    {
        const StageTimer timer(report.timings, "optimise");
        const GaussNewtonCgReport optimised = coarse_minimiser_->minimise(threads_, positions, execution);
        report.iterations = optimised.iterations;
        report.converged = optimised.converged;
        report.stop_reason = optimised.converged ? "converged at the coarse level" : "iteration limit";
    }
    {
        const StageTimer timer(report.timings, "split");
        hierarchy_.split(0, -1, positions, threads_, execution);
    }
    {
        const StageTimer timer(report.timings, "relax");
        for (int sweep = 0; sweep < kSweeps; ++sweep)
            relaxation_->sweep(positions, threads_, execution);
    }
    report.energies.push_back(fine_energy(positions));
    return report;
}

double PaperDecoder::fine_energy(const Positions& positions) const {
    double sum = 0.0;
    for (const Index row : fine_.rows) {
        sum += (Vector3(positions.row(row)) - predict(encoding_.ring_of(row), positions)).squaredNorm();
    }
    return 0.5 * sum;
}

std::vector<Index> PaperDecoder::level_sizes() const {
    std::vector<Index> sizes = {static_cast<Index>(fine_.free.size())};
    for (const Level& level : hierarchy_.levels) {
        sizes.push_back(level.free_count);
    }
    return sizes;
}

void PaperDecoder::solve_base(Positions& positions, Execution& execution) {
    if (base_unknowns_.free.empty()) return;
    // The better of two starts: where they are, and carried along with the anchors. Chosen before solving: where
    // anchors leave something open, both may end at energies that are zero but for rounding, and only one is near.
    // Where the base mesh has no residuals at all, what follows the anchors is taken.
    const Positions all_carried = carry_parts(components_, region_.positions, positions);
    Positions carried = positions;
    for (const Index v : base_unknowns_.free)
        carried.row(v) = all_carried.row(v);
    if (base_->energy(carried, threads_, execution) <= base_->energy(positions, threads_, execution)) {
        positions = std::move(carried);
    }
    MinimiseOptions options;
    options.step_tolerance = kBaseTolerance * bounding_box_diagonal(region_.positions);
    options.threads = threads_;
    SparseCholesky cholesky;
    minimise(*base_, cholesky, base_unknowns_, options, positions, execution);
}

std::size_t PaperDecoder::bytes() const {
    return encoding_.bytes() + hierarchy_.bytes() + coarse_->bytes() + base_->bytes() + relaxation_->bytes();
}

}  // namespace meanvalue
