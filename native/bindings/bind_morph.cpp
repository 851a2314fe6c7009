#include <pybind11/stl.h>

#include <algorithm>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/blend.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/morph/morpher.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

/// The triangles of all shapes. @param faces of one mesh, or (m, 3) for each shape, which must be equal.
Triangles own_faces(const py::object& faces, const std::vector<SharedPositions>& shapes) {
    const std::size_t shape_count = shapes.size();
    const std::optional<Polygons> polygons = as_polygons(faces);
    if (polygons && shape_count > 0) return triangulate(*shapes.front(), *polygons).triangles;
    const py::array array = array_or_nothing(faces);
    const bool are_several = array ? array.ndim() == 3 : py::isinstance<py::sequence>(faces);
    if (!are_several) return as_triangles(faces, "faces");
    const auto sequence = py::list(faces);
    if (sequence.size() != shape_count || shape_count == 0) {
        throw ::meanvalue::InvalidInput(message("faces are given of ", sequence.size(), " meshes, but there are ",
                                                shape_count, " shapes; give one (m, 3) for all, or one for each"));
    }
    Triangles first = as_triangles(sequence[0], "faces[0]");
    for (std::size_t k = 1; k < shape_count; ++k) {
        const Triangles other = as_triangles(sequence[k], message("faces[", k, "]").c_str());
        if (other.rows() != first.rows()) {
            throw ::meanvalue::InvalidInput(message("faces[", k, "] has ", other.rows(),
                                                    " triangles, but faces[0] has ", first.rows(),
                                                    "; all shapes must be of one mesh"));
        }
        for (Eigen::Index f = 0; f < first.rows(); ++f) {
            if (other.row(f) == first.row(f)) continue;
            throw ::meanvalue::InvalidInput(message("triangle ", f, " is (", other(f, 0), ", ", other(f, 1), ", ",
                                                    other(f, 2), ") in faces[", k, "], but (", first(f, 0), ", ",
                                                    first(f, 1), ", ", first(f, 2),
                                                    ") in faces[0]; all shapes must be of one mesh"));
        }
    }
    return first;
}

/// (k,) or (k, n), shape after shape.
std::vector<double> own_weights(const py::object& weights, std::size_t shape_count, std::size_t vertex_count) {
    const py::array array = array_or_nothing(weights);
    const int dimensions = array && array.ndim() == 2 ? 2 : 1;
    const FloatArray numbers = as_floats(weights, "weights", dimensions, "(k,) or (k, n) of float");
    const bool fits = static_cast<std::size_t>(numbers.shape(0)) == shape_count &&
                      (dimensions == 1 || static_cast<std::size_t>(numbers.shape(1)) == vertex_count);
    if (!fits) {
        throw ::meanvalue::InvalidInput(message("weights has the shape ", std::string(py::str(array.attr("shape"))),
                                                "; give (", shape_count, ",), one for each shape, or (", shape_count,
                                                ", ", vertex_count, "), one for each of its vertices as well"));
    }
    return {numbers.data(), numbers.data() + numbers.size()};
}

Task start_bind_morph(const py::object& shapes, const py::object& faces, const std::optional<py::object>& anchors,
                      int threads, bool portable, const SharedExecution& execution) {
    const std::vector<SharedPositions> owned = own_shapes(shapes, "shapes");
    MorphBinding binding(owned, std::make_shared<const Triangles>(own_faces(faces, owned)));
    if (anchors) binding.anchors = as_indices(*anchors, "anchors", "vertex");
    binding.threads = threads;
    binding.instructions = portable ? InstructionSet::kPortable : InstructionSet::kFastest;
    const SharedExecution held = execution_or_new(execution);
    return {held, [binding, held]() -> Task::Deliver {
                wait_for_cancelled_tasks(*held);
                const auto morpher = std::make_shared<Morpher>(binding, *held);
                return [morpher] { return py::cast(morpher); };
            }};
}

Task start_solve(const std::shared_ptr<Morpher>& morpher, const py::object& weights,
                 const std::optional<py::object>& parts, int threads, const SharedExecution& execution) {
    MorphOptions options;
    options.threads = threads;
    if (parts) options.parts = as_indices(*parts, "parts", "shape");
    const SharedExecution held = execution_or_new(execution);
    return {held,
            [morpher, options, held,
             shares = own_weights(weights, morpher->report().shape_count,
                                  morpher->report().vertex_count)]() -> Task::Deliver {
                const auto solution = std::make_shared<Solution>(morpher->solve(shares, options, *held));
                return [solution] { return py::cast(solution); };
            }};
}

Encoding blend_encodings(const std::vector<std::shared_ptr<Encoding>>& encodings, const py::object& weights,
                         int threads, const SharedExecution& execution) {
    if (std::find(encodings.begin(), encodings.end(), nullptr) != encodings.end()) {
        throw ::meanvalue::InvalidInput("encodings has a None; give what encode() returns of each shape");
    }
    const auto shapes = static_cast<Index>(encodings.size());
    const Index vertices = encodings.empty() ? 0 : encodings.front()->vertex_count();
    const std::vector<double> values = own_weights(weights, shapes, vertices);
    const SharedExecution held = execution_or_new(execution);
    std::vector<const Encoding*> of_shapes;
    of_shapes.reserve(encodings.size());
    for (const auto& encoding : encodings)
        of_shapes.push_back(encoding.get());
    return beside(
        held, [&] { return blend(of_shapes, ShapeWeights(values, shapes, vertices), thread_count(threads), *held); });
}

constexpr const char* kBindArguments =
    "shapes: (k, n, 3), or a sequence of two or more (n, 3): shapes of one mesh, in any units and places.\n"
    "faces: (m, 3) int32 triangles of all of them; or one (m, 3) for each shape, which must be equal.\n"
    "anchors: (a,) vertex numbers, or None: a part with three or more of them is placed by them instead of by all\n"
    "of its vertices.\n"
    "threads: 0 for every core; results do not depend on it.\n"
    "portable: with the instructions that every processor of this architecture has: slower, the same bits.\n"
    "Raises InvalidInput that names what is wrong with which shape, SolverFailure, Cancelled.";

}  // namespace

void bind_morph(py::module_& module) {
    py::class_<MorphReport>(module, "MorphReport", py::module_local(),
                            "What binding several shapes found, and what it cost.")
        .def_readonly("shape_count", &MorphReport::shape_count)
        .def_readonly("vertex_count", &MorphReport::vertex_count)
        .def_readonly("component_count", &MorphReport::component_count, "int: parts of the mesh; each is placed.")
        .def_readonly("timings", &MorphReport::timings, "dict: stage -> seconds.")
        .def_readonly("bytes", &MorphReport::bytes, "int: held.");

    py::class_<Morpher, std::shared_ptr<Morpher>> morpher(
        module, "Morpher", py::module_local(),
        "Several shapes of one mesh, to be mixed by weights (paper, section 4.3): expensive to make, cheap to "
        "solve.\n\n"
        "In-between shapes turn where linear ones shrink: cells, each a vertex with its ring, are averaged in local\n"
        "frames, and so are their rotations; the shape that agrees best with them is found by a linear solve.");
    const auto def_bind = [&](auto&& define, const std::string& text) {
        define(py::arg("shapes"), py::arg("faces"), py::arg("anchors") = py::none(), py::kw_only(),
               py::arg("threads") = 0, py::arg("portable") = false, py::arg("execution") = py::none(),
               (text + "\n\n" + kBindArguments).c_str());
    };
    def_bind(
        [&](const auto&... arguments) {
            morpher.def(py::init([](const py::object& shapes, const py::object& faces,
                                    const std::optional<py::object>& anchors, int threads, bool portable,
                                    const SharedExecution& execution) {
                            return start_bind_morph(shapes, faces, anchors, threads, portable, execution)
                                .result()
                                .cast<std::shared_ptr<Morpher>>();
                        }),
                        arguments...);
        },
        "Bind shapes.");
    def_bind([&](const auto&... arguments) { module.def("start_bind_morph", &start_bind_morph, arguments...); },
             "As Morpher(), beside the interpreter. Returns a Task whose result is the Morpher.");
    def_with_start(
        morpher, "solve", &start_solve,
        "The shape between all others, or beyond them.\n\n"
        "weights: (k,), one for each shape, or (k, n), one for each of its vertices as well; any numbers, also\n"
        "below 0 and above 1. Those of a vertex are divided by their sum. At 1 for one shape and 0 for the\n"
        "others the result is that shape.\n"
        "parts: numbers of the shapes that enter only where they have a weight, where weights are (k, n): they\n"
        "are placed by what fits best where they enter, and the whole is a mix of the others. None: all but the\n"
        "one with the largest mean weight. Name them where weights change from solve to solve, as with sliders.\n"
        "threads: 0 for as many as it was bound with.\n"
        "execution: an Execution by which another thread cancels the solve and sees how far it is.\n"
        "Returns a Solution. Each part of the mesh is placed by the best fit of rotation and translation to the\n"
        "average positions. The result depends on the weights alone. Threads may solve on one morpher side by\n"
        "side. Raises InvalidInput, SolverFailure, Cancelled; the morpher stays usable.",
        py::arg("weights"), py::kw_only(), py::arg("parts") = py::none(), py::arg("threads") = 0,
        py::arg("execution") = py::none());
    morpher.def_property_readonly("report", &Morpher::report, py::return_value_policy::reference_internal,
                                  "MorphReport: what bind found, and what it cost.");
    module.def(
        "blend", &blend_encodings, py::arg("encodings"), py::arg("weights"), py::kw_only(), py::arg("threads") = 0,
        py::arg("execution") = py::none(),
        "The average of encodings (paper, section 4.3).\n\n"
        "encodings: k of them, by encode(), of shapes of one mesh. weights: (k,) or (k, n), as of Morpher.solve().\n"
        "The coefficients of equation 13 are averaged, row i by the weights of vertex i. Returns an Encoding, whose\n"
        "`guarded` is that of the first. Raises InvalidInput that names a vertex whose rings differ, as where one\n"
        "shape has no area; Cancelled.");
}

}  // namespace meanvalue::bindings
