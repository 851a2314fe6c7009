#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/transfer/transfer.h"

namespace meanvalue::bindings {
namespace {

Task start_transfer(const py::object& source_rest, const py::object& source_shapes, const py::object& source_faces,
                    const py::object& target_rest, const py::object& target_faces, const py::object& correspondence,
                    const std::optional<py::object>& close, int threads,
                    const std::shared_ptr<Execution>& execution) {
    const auto source = std::make_shared<const Positions>(own_positions(source_rest, "source_rest"));
    const auto target = std::make_shared<const Positions>(own_positions(target_rest, "target_rest"));
    TransferBinding binding;
    binding.source_rest = source;
    binding.source_faces = std::make_shared<const Triangles>(triangles_of(source_faces, *source, "source_faces"));
    binding.target_rest = target;
    binding.target_faces = std::make_shared<const Triangles>(triangles_of(target_faces, *target, "target_faces"));
    if (!py::isinstance<py::sequence>(correspondence) || py::len(correspondence) != 2) {
        throw ::meanvalue::InvalidInput(
            "correspondence is no pair; give (faces (n,), weights (n, 3)), one of each for a vertex of the target");
    }
    const auto pair = py::reinterpret_borrow<py::sequence>(correspondence);
    binding.faces = as_indices(pair[0], "correspondence[0]", "face");
    binding.weights = own_positions(pair[1], "correspondence[1]");
    binding.threads = threads;
    const auto shapes = std::make_shared<std::vector<SharedPositions>>(own_shapes(source_shapes, "source_shapes"));
    const std::vector<char> closes = as_flags(close, "close").value_or(std::vector<char>(shapes->size(), 1));
    const std::shared_ptr<Execution> held = execution_or_new(execution);
    return {held, [=]() -> Task::Deliver {
                const auto found = std::make_shared<Positions>(transfer(binding, *shapes, closes, *held));
                return [found, count = shapes->size(), rows = target->rows()] {
                    return to_array(std::move(*found)).attr("reshape")(count, rows, 3);
                };
            }};
}

}  // namespace

void bind_transfer(py::module_& module) {
    def_with_start(
        module, "transfer", &start_transfer,
        "Shape keys of one mesh on another, of other faces and proportions.\n\n"
        "Offsets turn, grow and stretch as the target does beside the source; lids and lips that meet go on "
        "meeting;\n"
        "parts that move rigidly, as eyes and teeth, do so here; what a shape leaves where it is stays exactly.\n"
        "source_rest: (m, 3). source_shapes: (s, m, 3), positions with each key alone at value 1.\n"
        "target_rest: (n, 3). source_faces, target_faces: as of Deformer.\n"
        "correspondence: (face (n,), weights of its corners (n, 3) with the sum 1), where on the source each vertex\n"
        "of the target is, as of Surface.nearest(). A face is a row of source_faces, or where these are not\n"
        "triangles, one that triangulate() makes of them.\n"
        "close: (s,) bool, whether what meets in a shape meets on the target; None: all. False is for shapes that\n"
        "are meant with another alone, such as mouthClose with jawOpen.\n"
        "threads: 0 for every core; results do not depend on it.\n"
        "execution: an Execution by which another thread cancels and sees how far it is.\n"
        "Returns (s, n, 3) float64. Raises InvalidInput that names what is wrong with which array, SolverFailure,\n"
        "Cancelled.",
        py::arg("source_rest"), py::arg("source_shapes"), py::arg("source_faces"), py::arg("target_rest"),
        py::arg("target_faces"), py::arg("correspondence"), py::kw_only(), py::arg("close") = py::none(),
        py::arg("threads") = 0, py::arg("execution") = py::none());
}

}  // namespace meanvalue::bindings
