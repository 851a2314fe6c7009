#include <pybind11/stl.h>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/follow/follower.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

FollowKind kind_from_name(const std::string& name) {
    if (name == "auto") return FollowKind::kAuto;
    if (name == "cloth") return FollowKind::kCloth;
    if (name == "rigid") return FollowKind::kRigid;
    throw ::meanvalue::InvalidInput(message("kind is '", name, "'; give 'auto', 'cloth' or 'rigid'"));
}

std::shared_ptr<Follower> make_follower(const py::object& carrier_vertices, const py::object& carrier_faces,
                                        const py::object& vertices, const py::object& faces, const std::string& kind,
                                        int threads, bool portable, const SharedExecution& execution) {
    const auto carrier = std::make_shared<const Positions>(own_positions(carrier_vertices, "carrier_vertices"));
    const auto worn = std::make_shared<const Positions>(own_positions(vertices, "vertices"));
    FollowBinding binding(carrier,
                          std::make_shared<const Triangles>(triangles_of(carrier_faces, *carrier, "carrier_faces")),
                          worn, std::make_shared<const Triangles>(triangles_of(faces, *worn)));
    binding.kind = kind_from_name(kind);
    binding.threads = threads;
    binding.instructions = portable ? InstructionSet::kPortable : InstructionSet::kFastest;
    const SharedExecution held = execution_or_new(execution);
    return beside(held, [&] { return std::make_shared<Follower>(binding, *held); });
}

Task start_follow(const std::shared_ptr<Follower>& follower, const py::object& carrier_posed, int threads,
                  const SharedExecution& execution) {
    const Positions posed = own_positions(carrier_posed, "carrier_posed");
    const SharedExecution held = execution_or_new(execution);
    return {held, [follower, posed, threads, held]() -> Task::Deliver {
                const auto found = std::make_shared<Positions>(follower->follow(posed, threads, *held));
                return [found] { return to_array(std::move(*found)); };
            }};
}

}  // namespace

void bind_follower(py::module_& module) {
    py::class_<Follower, std::shared_ptr<Follower>> follower(
        module, "Follower", py::module_local(),
        "A mesh that goes along with another, its carrier: clothes, hair, eyes, buttons on a body.\n\n"
        "Clothes bend with the surface below them and do not sink into it. Small things are rigid, and go along\n"
        "with the carrier or the clothes, whichever is nearer. Where they go depends on the carrier's pose alone.");
    follower.def(py::init(&make_follower), py::arg("carrier_vertices"), py::arg("carrier_faces"), py::arg("vertices"),
                 py::arg("faces"), py::kw_only(), py::arg("kind") = "auto", py::arg("threads") = 0,
                 py::arg("portable") = false, py::arg("execution") = py::none(),
                 "carrier_vertices: (c, 3). vertices: (n, 3). Both at rest, in one space.\n"
                 "carrier_faces, faces: (m, 3), or faces of any number of corners, as of Deformer.\n"
                 "kind: \"auto\", by the size of each connected part and how it lies on the carrier; \"cloth\";\n"
                 "or \"rigid\". Parts of fewer than four vertices are always rigid.\n"
                 "threads: 0 for every core; results do not depend on it. portable: as of Deformer.\n"
                 "Raises InvalidInput that names what is wrong with which array, Cancelled.");
    def_with_start(follower, "follow", &start_follow,
                   "Where the mesh goes to with its carrier.\n\n"
                   "carrier_posed: (c, 3). threads: 0 for as many as it was bound with. Returns (n, 3) float64; the\n"
                   "same bits for any number of threads. Raises InvalidInput, Cancelled.",
                   py::arg("carrier_posed"), py::kw_only(), py::arg("threads") = 0,
                   py::arg("execution") = py::none());
    follower
        .def_property_readonly(
            "kinds",
            [](const Follower& of) {
                std::vector<std::string> names;
                for (const FollowKind kind : of.kinds())
                    names.emplace_back(kind == FollowKind::kCloth ? "cloth" : "rigid");
                return py::tuple(py::cast(names));
            },
            "tuple of str: \"cloth\" or \"rigid\" for each connected part, in the order of their first vertices.")
        .def_property_readonly(
            "parts", [](const py::object& of) { return view_of(of.cast<const Follower&>().part_of(), of); },
            "(n,) int32: the connected part of each vertex, of kinds.");
}

}  // namespace meanvalue::bindings
