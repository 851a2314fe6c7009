#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "reference/arap.h"
#include "reference/laplacian.h"
#include "reference/laplacian_surface_editing.h"
#include "reference/poisson_morph.h"
#include "reference/pyramid.h"
#include "reference/rotation_invariant.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

constexpr const char* kArguments =
    "vertices: (n, 3) rest positions; faces: (m, 3) int32 triangles; anchors: (k,) vertex numbers;\n"
    "targets: (k, 3), in the order of the anchors, which meet them exactly.\n"
    "roi: (n,) bool, True may move; outside it everything keeps its place. None: every vertex may.\n"
    "threads: 0 for every core; the result does not depend on it.\n"
    "Returns (n, 3) float64. Raises InvalidInput that names what is wrong, SolverFailure, Cancelled.";

/// Binds a method that takes (problem, execution, options...): converts what all of them share, and calls it with the
/// interpreter released.
template <typename... Options, typename Method, typename... Names>
void bind_baseline(py::module_& module, const char* name, const std::string& summary, const Method& method,
                   const Names&... names) {
    const auto call = [method](const py::object& vertices, const py::object& faces, const py::object& anchors,
                               const py::object& targets, const std::optional<py::object>& roi, Options... options,
                               int threads, const SharedExecution& execution) {
        const PositionsArray positions(vertices, "vertices");
        const Triangles triangles = triangles_of(faces, positions.view());
        const PositionsArray target_positions(targets, "targets");
        const baselines::Problem problem{
            positions.view(),     triangles, as_indices(anchors, "anchors", "vertex"), target_positions.view(),
            as_flags(roi, "roi"), threads};
        const SharedExecution held = execution_or_new(execution);
        return to_array(beside(held, [&] { return Positions(method(problem, *held, options...)); }));
    };
    const std::string text = summary + "\n" + kArguments;
    module.def(name, call, py::arg("vertices"), py::arg("faces"), py::arg("anchors"), py::arg("targets"),
               py::arg("roi") = py::none(), py::kw_only(), names..., py::arg("threads") = 0,
               py::arg("execution") = py::none(), text.c_str());
}

void bind_linear(py::module_& module) {
    bind_baseline(
        module, "laplacian",
        "Laplacian coordinates (Alexa 2003): uniform weights, kept as vectors, so that details do not turn.\n",
        baselines::laplacian);
    bind_baseline<int>(
        module, "laplacian_surface_editing",
        "Laplacian surface editing (Sorkine et al. 2004): Laplacian coordinates up to linearized similarities.\n\n"
        "rounds: 1 for the published linear method; more turn the coordinates by the best rotation of their\n"
        "ring after each solve and fit the similarities anew.\n",
        [](const baselines::Problem& problem, Execution& execution, int rounds) {
            return baselines::laplacian_surface_editing(problem, {rounds}, execution);
        },
        py::arg("rounds") = baselines::LaplacianSurfaceEditingOptions().rounds);
    bind_baseline(
        module, "rotation_invariant",
        "Linear rotation-invariant coordinates (Lipman et al. 2005): edges are kept in local frames, and frames\n"
        "relative to their neighbors', by two linear solves, frames first.\n\n"
        "The frame of an anchor is turned by the rotation that fits best to those of it and its ring that are\n"
        "anchors; of a single anchor, or on a line, to its ring where Laplacian coordinates lead.\n",
        baselines::rotation_invariant);
}

void bind_iterative(py::module_& module) {
    bind_baseline<int>(
        module, "pyramid",
        "Pyramid coordinates (Sheffer and Kraevoy 2004), a reconstruction.\n\n"
        "sweeps: how many damped Jacobi sweeps are made; there is no objective that could tell when to end.\n",
        [](const baselines::Problem& problem, Execution& execution, int sweeps) {
            return baselines::pyramid(problem, {sweeps}, execution);
        },
        py::arg("sweeps") = baselines::PyramidOptions().sweeps);
    const baselines::ArapOptions defaults;
    bind_baseline<int, double>(
        module, "arap",
        "As rigid as possible, spokes (Sorkine and Alexa 2007), with positive cotangent weights.\n\n"
        "iterations: at most; tolerance: stop when no vertex moves farther than this share of the rest\n"
        "shape's bounding-box diagonal.\n",
        [](const baselines::Problem& problem, Execution& execution, int iterations, double tolerance) {
            return baselines::arap(problem, {iterations, tolerance}, execution);
        },
        py::arg("iterations") = defaults.iterations, py::arg("tolerance") = defaults.tolerance);
}

void bind_morphs(py::module_& module) {
    module.def(
        "poisson_morph",
        [](const py::object& first, const py::object& second, const py::object& faces, double share,
           const SharedExecution& execution) {
            const PositionsArray from(first, "first");
            const PositionsArray to(second, "second");
            const Triangles triangles = triangles_of(faces, from.view());
            const SharedExecution held = execution_or_new(execution);
            return to_array(beside(
                held, [&] { return baselines::poisson_morph(from.view(), to.view(), triangles, share, *held); }));
        },
        py::arg("first"), py::arg("second"), py::arg("faces"), py::arg("share"), py::kw_only(),
        py::arg("execution") = py::none(),
        "Poisson shape interpolation (Xu et al. 2005): rotations and stretches of triangles go evenly.\n\n"
        "first, second: (n, 3) shapes of one mesh; faces: (m, 3); share: 0 for the first, 1 for the second.\n"
        "Turns are taken the shorter way round. Returns (n, 3) float64. Raises InvalidInput, SolverFailure, "
        "Cancelled.");
}

}  // namespace

void bind_baselines(py::module_& module) {
    py::module_ baselines = module.def_submodule(
        "baselines", "Other methods in one calling form, to compare with: docs/algorithm.md, \"Baselines\".");
    bind_linear(baselines);
    bind_iterative(baselines);
    bind_morphs(baselines);
    py::module_::import("sys").attr("modules")["meanvalue.baselines"] =
        baselines;  // for `import meanvalue.baselines`
}

}  // namespace meanvalue::bindings
