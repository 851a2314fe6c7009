#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

Encoding encode_mesh(const py::object& vertices, const py::object& faces, int threads,
                     const SharedExecution& execution) {
    const PositionsArray array(vertices, "vertices");
    const auto positions = array.view();
    const Triangles triangles = triangles_of(faces, positions);
    const SharedExecution held = execution_or_new(execution);
    return beside(held, [&] {
        require_finite(positions, "vertices");
        require_moderate_extent(positions);
        const OneRings rings = collect_one_rings(static_cast<Index>(positions.rows()), triangles, *held);
        return encode(rings, positions, thread_count(threads), *held, true);
    });
}

PositionsArray positions_of(const Encoding& encoding, const py::object& vertices) {
    PositionsArray positions(vertices, "vertices");
    if (positions.view().rows() != encoding.vertex_count()) {
        throw InvalidInput(message("vertices has ", positions.view().rows(), " rows, but the encoding has ",
                                   encoding.vertex_count(), " vertices"));
    }
    return positions;
}

py::array_t<double> predict_positions(const Encoding& encoding, const py::object& vertices, int threads,
                                      const SharedExecution& execution) {
    const PositionsArray positions = positions_of(encoding, vertices);
    const SharedExecution held = execution_or_new(execution);
    return to_array(
        beside(held, [&] { return predict_all(encoding, positions.view(), thread_count(threads), *held); }));
}

double energy_of(const Encoding& encoding, const py::object& vertices, int threads,
                 const SharedExecution& execution) {
    const PositionsArray positions = positions_of(encoding, vertices);
    const SharedExecution held = execution_or_new(execution);
    return beside(held, [&] { return energy(encoding, positions.view(), thread_count(threads), *held); });
}

py::dict guarded_by(const Encoding& encoding) {
    py::dict result;
    for (const auto& [reason, vertices] : encoding.guarded_by_reason()) {
        result[py::str(reason)] = py::array_t<Index>(static_cast<py::ssize_t>(vertices.size()), vertices.data());
    }
    return result;
}

/// A getter that gives a vector of the encoding as a read-only array which keeps the encoding alive.
template <typename T>
auto viewer(std::vector<T> Encoding::*items) {
    return [items](const py::object& self) { return view_of(self.cast<const Encoding&>().*items, self); };
}

}  // namespace

void bind_encoding(py::module_& module) {
    py::class_<Encoding, std::shared_ptr<Encoding>>(
        module, "Encoding", py::module_local(),
        "Mean-value encoding of a mesh (paper, section 2): n vertices, h half-edges.\n\n"
        "Invariant under rotation, translation and uniform scale, not under reflection.")
        .def_property_readonly("ring_offsets", viewer(&Encoding::ring_offsets),
                               "(n+1,) int32: ring i is ring[ring_offsets[i]:ring_offsets[i+1]].")
        .def_property_readonly("ring", viewer(&Encoding::ring),
                               "(h,) int32: the one-ring of each vertex, counter-clockwise seen from outside.")
        .def_property_readonly("weights", viewer(&Encoding::weights),
                               "(h,) float64: mean-value weights w_ij, summing to 1 over a ring (equation 7).")
        .def_property_readonly("cotangents", viewer(&Encoding::cotangents),
                               "(h,) float64: b_ij, cotangent of the angle between edge and normal (equation 9).")
        .def_property_readonly("guarded", viewer(&Encoding::guarded),
                               "(g,) int32: vertices encoded by a fallback rule, ascending.")
        .def_property_readonly("guarded_by", &guarded_by,
                               "dict: reason -> (g,) int32, the vertices that it applies to.")
        .def_property_readonly("vertex_count", &Encoding::vertex_count, "int: n.")
        .def("predict", &predict_positions, py::arg("vertices"), py::kw_only(), py::arg("threads") = 0,
             py::arg("execution") = py::none(),
             "Predict every vertex from its ring: F_i(V), equation 13.\n\n"
             "vertices: (n, 3) positions. Returns (n, 3); a vertex whose surroundings span no plane is given back\n"
             "as it is. Raises InvalidInput for another shape.")
        .def("energy", &energy_of, py::arg("vertices"), py::kw_only(), py::arg("threads") = 0,
             py::arg("execution") = py::none(),
             "G, equation 15, over all vertices, in squared units of the input.\n\n"
             "To compare meshes, divide by the squared bounding-box diagonal.");

    module.def("encode", &encode_mesh, py::arg("vertices"), py::arg("faces"), py::kw_only(), py::arg("threads") = 0,
               py::arg("execution") = py::none(),
               "Encode every vertex by its one-ring (equations 1 to 9).\n\n"
               "vertices: (n, 3) float64; faces: as of Deformer(), counter-clockwise seen from outside.\n"
               "threads: 0 for every core; the result does not depend on it.\n"
               "Raises InvalidInput that names what is wrong, Cancelled.");
}

}  // namespace meanvalue::bindings
