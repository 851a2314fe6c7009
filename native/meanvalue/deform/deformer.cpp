#include "meanvalue/deform/deformer.h"

#include <cmath>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/fixed_vertices.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/solver/similarity.h"

namespace meanvalue {
namespace {

// A position's error goes with the root of the energy's, so the energy may settle much earlier than the vertices.
constexpr double kSettledPerTolerance = 100.0;
// Residuals below this share of the diagonal are rounding.
constexpr double kRounding = 1e-13;
// Fixed vertices that a similarity carries to within this share of the diagonal leave nothing to follow.
constexpr double kNegligibleMove = 1e-12;

}  // namespace

Method method_from_name(const std::string& name) {
    if (name == "full") return Method::kFull;
    throw InvalidInput(message("method is '", name, "'; this version knows 'full'"));
}

Deformer::Deformer(const Binding& binding, Execution& execution)
    : rest_(binding.vertices), anchors_(binding.anchors), threads_(thread_count(binding.threads)) {
    require_finite(binding.vertices, "vertices");
    is_fixed_ = fixed_flags(static_cast<Index>(rest_.rows()), binding.anchors, binding.roi);
    diagonal_ = bounding_box_diagonal(rest_);
    {
        const StageTimer timer(report_.timings, "encode");
        const TriangleMesh mesh(static_cast<Index>(rest_.rows()), binding.faces, execution);
        report_.detached_triangle_count = mesh.detached_count();
        encoding_ = encode(collect_one_rings(mesh, execution), rest_, threads_, execution);
    }
    {
        execution.begin_stage("analyse");
        const StageTimer timer(report_.timings, "analyse");
        components_ = find_components(rest_, binding.faces, is_fixed_);
        unknowns_ = find_unknowns(encoding_, solved_as_fixed(is_fixed_, components_));
        system_.emplace(encoding_, unknowns_, execution);
        if (!unknowns_.free.empty()) cholesky_.analyse(system_->matrix().matrix(), execution);
    }
    report_.guarded = encoding_.guarded;
    for (const auto& [reason, vertices] : encoding_.guarded_by_reason()) {
        report_.guarded_reasons[reason] = static_cast<Index>(vertices.size());
    }
    report_.components = components_.parts;
    report_.vertex_count = static_cast<Index>(rest_.rows());
    report_.free_count = static_cast<Index>(unknowns_.free.size());
    report_.anchor_count = static_cast<Index>(anchors_.size());
    report_.row_count = static_cast<Index>(unknowns_.rows.size());
    report_.bytes = encoding_.bytes() + system_->bytes();
}

Positions Deformer::place_anchors(const PositionsView& targets, const std::optional<PositionsView>& start) const {
    require_targets(targets, anchors_);
    Positions positions = rest_;
    if (start) {
        if (start->rows() != rest_.rows()) {
            throw InvalidInput(
                message("start has ", start->rows(), " rows, but the mesh has ", rest_.rows(), " vertices"));
        }
        require_finite(*start, "start");
        for (Index v = 0; v < positions.rows(); ++v) {
            if (!is_fixed_[v]) positions.row(v) = start->row(v);
        }
    }
    for (std::size_t k = 0; k < anchors_.size(); ++k)
        positions.row(anchors_[k]) = targets.row(k);
    return positions;
}

void Deformer::choose_start(const MinimiseOptions& options, Positions& positions, Execution& execution) {
    if (unknowns_.free.empty()) return;
    Positions carried = carry_parts(rest_, positions, components_);
    Positions fixed_moves = positions - carried;
    for (const Index v : unknowns_.free)
        fixed_moves.row(v).setZero();
    if (fixed_moves.cwiseAbs().maxCoeff() > kNegligibleMove * diagonal_) {
        carried = follow_fixed_moves(*system_, cholesky_, unknowns_, options, carried, fixed_moves, execution);
    }
    for (Index v = 0; v < carried.rows(); ++v) {
        if (unknowns_.slot[v] < 0) carried.row(v) = positions.row(v);
    }
    if (system_->energy(carried, threads_, execution) < system_->energy(positions, threads_, execution)) {
        positions = std::move(carried);
    }
}

Solution Deformer::solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                         const SolveOptions& options, Execution& execution) {
    if (!(options.tolerance > 0.0)) {
        throw InvalidInput(message("tolerance is ", options.tolerance, "; give a positive number"));
    }
    if (options.max_iterations < 0) {
        throw InvalidInput(message("max_iterations is ", options.max_iterations, "; give 0 or more"));
    }
    const std::lock_guard<std::mutex> lock(solving_);
    Solution solution;
    solution.vertices = place_anchors(targets, start);
    MinimiseOptions minimise_options;
    minimise_options.step_tolerance = options.tolerance * diagonal_;
    minimise_options.settled_decrease = kSettledPerTolerance * options.tolerance;
    minimise_options.negligible_energy =
        0.5 * static_cast<double>(unknowns_.rows.size()) * std::pow(kRounding * diagonal_, 2);
    minimise_options.max_iterations = options.max_iterations;
    minimise_options.threads = threads_;
    Timings total;
    MinimiseReport report;
    {
        const StageTimer timer(total, "total");
        if (!start) choose_start(minimise_options, solution.vertices, execution);
        report = minimise(*system_, cholesky_, unknowns_, minimise_options, solution.vertices, execution);
    }
    solution.energies = report.energies;
    if (!report.energies.empty()) {
        solution.initial_energy = report.energies.front();
        solution.energy = report.energies.back();
    }
    solution.initial_gradient = report.initial_gradient;
    solution.gradient = report.gradient;
    solution.iterations = report.iterations;
    solution.converged = report.converged();
    solution.stop_reason = describe(report.stop_reason);
    solution.timings = report.timings;
    solution.timings.merge(total);
    return solution;
}

}  // namespace meanvalue
