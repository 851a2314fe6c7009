// What bind and solve report.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings/bind.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue::bindings {
namespace {

py::array_t<double> solution_vertices(const py::object& self) {
    const auto& solution = self.cast<const Solution&>();
    py::array_t<double> array({static_cast<py::ssize_t>(solution.vertices.rows()), py::ssize_t{3}},
                              solution.vertices.data(), self);
    array.attr("flags").attr("writeable") = false;
    return array;
}

}  // namespace

void bind_reports(py::module_& module) {
    py::class_<Component>(module, "Component", py::module_local(), "One connected part of a bound mesh.")
        .def_readonly("vertex_count", &Component::vertex_count)
        .def_readonly("free_count", &Component::free_count)
        .def_readonly("fixed_count", &Component::fixed_count)
        .def_readonly("soft_count", &Component::soft_count, "int: of the free vertices, soft anchors.")
        .def_readonly("first_vertex", &Component::first_vertex, "int: its lowest vertex number.")
        .def_readonly("undetermined", &Component::undetermined,
                      "int: degrees of freedom of a similarity that its fixed points and soft anchors\n"
                      "leave open, 7, 4, 1 or 0.\n"
                      "Along those, its free vertices stay as near as can be to where a solve starts.");

    py::class_<BindReport>(module, "BindReport", py::module_local(), "What bind found, and what it cost.")
        .def_readonly("vertex_count", &BindReport::vertex_count)
        .def_readonly("free_count", &BindReport::free_count)
        .def_readonly("anchor_count", &BindReport::anchor_count)
        .def_readonly("level_sizes", &BindReport::level_sizes,
                      "list of int: free vertices in each level, finest first.")
        .def_readonly("row_count", &BindReport::row_count, "int: residuals that take part in a solve.")
        .def_readonly("longest_ring", &BindReport::longest_ring, "int: vertices in the longest ring of any level.")
        .def_readonly("detached_triangle_count", &BindReport::detached_triangle_count,
                      "int: triangles that fit no manifold and were kept as loose pieces.")
        .def_readonly("guarded", &BindReport::guarded, "list of int: vertices encoded by a fallback rule.")
        .def_property_readonly(
            "guarded_reasons",
            [](const BindReport& report) {
                std::map<std::string, std::size_t> counts;
                for (const auto& [reason, vertices] : report.guarded_by_reason)
                    counts[reason] = vertices.size();
                return counts;
            },
            "dict: reason -> number of vertices.")
        .def_readonly("guarded_by_reason", &BindReport::guarded_by_reason,
                      "dict: reason -> list of int, the vertices.")
        .def_readonly("components", &BindReport::components)
        .def_readonly("carriers", &BindReport::carriers,
                      "list of int, one for each of `components`: the place there of the part that carries it along\n"
                      "(loose='follow'), or -1.")
        .def_property_readonly(
            "part_of",
            [](const BindReport& report) {
                return py::array_t<Index>(static_cast<py::ssize_t>(report.part_of.size()), report.part_of.data());
            },
            "(n,) int32: the part of each vertex, a place in `components`.")
        .def_readonly("timings", &BindReport::timings, "dict: stage -> seconds, and 'total'.")
        .def_readonly("bytes", &BindReport::bytes,
                      "int: held by the bound mesh, and about what one solve at a time adds.");

    py::class_<Solution, std::shared_ptr<Solution>>(module, "Solution", py::module_local(),
                                                    "The result of one solve.")
        .def_property_readonly(
            "vertices", &solution_vertices,
            "(n, 3) float64, read-only: anchors exactly at their targets but for soft ones, fixed vertices exactly\n"
            "at rest. A view that keeps the solution alive; copy() gives one to write to.")
        .def_readonly(
            "energy", &Solution::energy,
            "float: what was minimized, in squared units of the input: G over the rows that depend on free\n"
            "vertices (equation 15), the cost of lengths where there is rigidity, and the springs of soft anchors.")
        .def_readonly("initial_energy", &Solution::initial_energy)
        .def_readonly("energies", &Solution::energies, "list: energy at the start and after each iteration.")
        .def_readonly("initial_gradient", &Solution::initial_gradient,
                      "float: norm of the derivative of `energy` by the free vertices, at the start.")
        .def_readonly(
            "gradient", &Solution::gradient,
            "float: the same at the end; method 'full': where it last linearized, 'paper': of its coarse level.")
        .def_property_readonly(
            "example_weights",
            [](const Solution& solution) -> py::object {
                if (solution.example_weights.empty()) return py::none();
                const auto count = static_cast<py::ssize_t>(solution.vertices.rows());
                const auto shapes = static_cast<py::ssize_t>(solution.example_weights.size()) / count;
                return py::array_t<double>({count, shapes}, solution.example_weights.data());
            },
            "(n, e + 1) float64: what the rest shape and each of e examples count at each vertex, one in all;\n"
            "None without examples.")
        .def_readonly("iterations", &Solution::iterations, "int: of the whole mesh, in the last stage.")
        .def_readonly("all_iterations", &Solution::all_iterations,
                      "int: with those of coarser levels and of the stages before the last.")
        .def_readonly(
            "converged", &Solution::converged,
            "bool: a minimum is near: steps were as short as asked for, or lowered the energy by too little\n"
            "to go on; method 'paper': of its base mesh and its coarse level.")
        .def_readonly(
            "stop_reason", &Solution::stop_reason,
            "str: why the solve ended.\n"
            "'converged': a minimum is near.\n"
            "'iteration limit': at max_iterations; a solve from this shape goes on.\n"
            "'no step lowers the energy further': at the limit of rounding; converged tells whether near a\n"
            "minimum.\n"
            "'the energy no longer falls': method 'full': in a long flat valley.\n"
            "'converged at the coarse level', 'base mesh: ...': method 'paper', whose last stages are sweeps.\n"
            "'no free vertices': nothing may move.")
        .def_readonly("timings", &Solution::timings, "dict: stage -> seconds, and 'total'.");
}

}  // namespace meanvalue::bindings
