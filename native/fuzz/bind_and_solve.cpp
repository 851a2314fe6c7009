#include <cmath>

#include "fuzz/entries.h"
#include "fuzz/odd_input.h"
#include "meanvalue/deform/bound_mesh.h"

namespace meanvalue::fuzz {
namespace {

SolveOptions read_options(Bytes& bytes, const Binding& binding) {
    SolveOptions options;
    options.tolerance = read_tolerance(bytes);
    options.max_iterations = read_max_iterations(bytes);
    options.settle = bytes.once_in(4);
    if (!binding.strengths.empty()) options.weights = read_weights(bytes, binding.anchors.size());
    return options;
}

bool is_free(const Binding& binding, const SolveOptions& options, std::size_t k) {
    return (k < binding.strengths.size() && std::isfinite(binding.strengths[k])) ||
           (k < options.weights.size() && options.weights[k] != 1.0);
}

void require_fixed_in_place(const Binding& binding, const SolveOptions& options, const Positions& targets,
                            const Solution& solution) {
    std::vector<char> is_anchor(binding.vertices->rows(), 0);
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        is_anchor[binding.anchors[k]] = 1;
        if (is_free(binding, options, k)) continue;
        require(solution.vertices.row(binding.anchors[k]) == targets.row(k), "an anchor is at its target");
    }
    for (std::size_t v = 0; binding.roi && v < binding.roi->size(); ++v) {
        if ((*binding.roi)[v] || is_anchor[v]) continue;
        require(solution.vertices.row(v) == binding.vertices->row(v), "what is outside the region stays");
    }
}

/// A loose part that is carried goes along with a held one, or with clothes that do.
void require_carriers(const BindReport& report, LooseRule rule) {
    require(report.carriers.size() == report.components.size(), "each part has a carrier or none");
    for (const Index carrier : report.carriers) {
        require(carrier < 0 || rule == LooseRule::kFollow, "where loose parts stay, none is carried");
        if (carrier < 0) continue;
        require(carrier < static_cast<Index>(report.carriers.size()), "what carries is a part of the mesh");
        const Index held = report.carriers[carrier] < 0 ? carrier : report.carriers[carrier];
        require(report.carriers[held] < 0, "what carries clothes is not carried");
        const Component& part = report.components[held];
        require(part.fixed_count + part.soft_count > 0, "what carries is held");
    }
}

/// Parts that nothing holds are at rest, or where the shape of what carries them says.
void require_loose_in_place(const Binding& binding, const Deformer& deformer, const Solution& solution) {
    const BindReport& report = deformer.report();
    Positions carried = solution.vertices;
    deformer.bound().loose_parts().carry(*binding.vertices, carried.data(), 1, Execution());
    require(carried == solution.vertices, "a loose part is where it is carried to");
    for (Index v = 0; v < report.vertex_count; ++v) {
        const Index number = report.part_of[v];
        const Component& part = report.components[number];
        if (report.carriers[number] >= 0 || part.fixed_count + part.soft_count > 0) continue;
        require(solution.vertices.row(v) == binding.vertices->row(v), "a part that nothing holds or carries stays");
    }
}

/// From rest, and from there to other targets.
void solve_twice(Bytes& bytes, const Mesh& mesh, const Binding& binding, Deformer& deformer) {
    std::optional<Positions> start;
    for (int turn = 0; turn < 2; ++turn) {
        const SolveOptions options = read_options(bytes, binding);
        const Positions targets = read_targets(bytes, mesh, binding.anchors);
        if (start && bytes.once_in(16)) (*start)(bytes.below(mesh.vertex_count()), 1) = bytes.number();
        Execution execution;
        const Solution solution =
            deformer.solve(targets, start ? std::optional<PositionsView>(*start) : std::nullopt, options, execution);
        require_solution(solution, mesh.vertex_count());
        require_fixed_in_place(binding, options, targets, solution);
        require_loose_in_place(binding, deformer, solution);
        if (mesh.vertex_count() > 0) start = solution.vertices;
    }
}

}  // namespace

void require_solution(const Solution& solution, Eigen::Index vertex_count) {
    require(solution.vertices.rows() == vertex_count, "a result has as many vertices as the mesh");
    require(solution.vertices.allFinite(), "every coordinate is a finite number");
    require(std::isfinite(solution.energy) && solution.energy >= 0.0, "an energy is a finite number, 0 or more");
    require(std::isfinite(solution.initial_energy), "so is the first");
    for (const double energy : solution.energies)
        require(std::isfinite(energy), "and those between");
    require(!std::isnan(solution.gradient) && !std::isnan(solution.initial_gradient), "a gradient is a number");
    require(!solution.stop_reason.empty(), "it is told why a solve ended");
}

Outcome bind_and_solve(Bytes bytes) {
    const Mesh mesh = read_mesh(bytes);
    Binding binding = read_binding(bytes, mesh);
    return outcome_of([&] {
        Execution execution;
        Deformer deformer(binding, execution);
        require(deformer.report().vertex_count == mesh.vertex_count(), "the report is of the mesh");
        require_carriers(deformer.report(), binding.loose);
        const Outcome outcome = outcome_of([&] { solve_twice(bytes, mesh, binding, deformer); });
        if (bytes.once_in(2)) {
            Binding again = deformer.binding_again();
            read_anchors(bytes, mesh.vertex_count(), again);
            Deformer other(again, execution, &deformer);
            require_carriers(other.report(), again.loose);
            solve_twice(bytes, mesh, again, other);
        } else if (outcome == Outcome::kRefused) {
            throw InvalidInput("the solve");
        } else if (outcome == Outcome::kFailed) {
            throw SolverFailure("the solve");
        }
    });
}

}  // namespace meanvalue::fuzz
