#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/bones/fit_bones.h"
#include "meanvalue/common/errors.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

/// An array that looks at numbers of what was found, and keeps it.
template <typename T>
py::array_t<T> look_at(const T* numbers, std::vector<py::ssize_t> shape, const py::object& owner) {
    py::array_t<T> array(std::move(shape), numbers, owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

Armature own_armature(const std::optional<py::object>& given, py::ssize_t frames) {
    Armature armature;
    if (!given) return armature;
    if (!py::isinstance<py::sequence>(*given) || py::len(*given) < 3 || py::len(*given) > 4)
        throw ::meanvalue::InvalidInput("armature is no tuple of heads, tails, parents, and transforms or not");
    const py::tuple parts(*given);
    armature.heads = own_positions(parts[0], "armature's heads");
    armature.tails = own_positions(parts[1], "armature's tails");
    armature.parents = as_indices(parts[2], "armature's parents", "bone");
    if (armature.parents.empty()) throw ::meanvalue::InvalidInput("armature has no bones; give one or more, or None");
    if (parts.size() < 4 || parts[3].is_none()) return armature;
    const FloatArray matrices = as_floats(parts[3], "armature's transforms", 4, "an array of shape (f, b, 4, 4)");
    const auto bones = static_cast<py::ssize_t>(armature.parents.size());
    if (matrices.shape(0) != frames || matrices.shape(1) != bones || matrices.shape(2) != 4 || matrices.shape(3) != 4)
        throw ::meanvalue::InvalidInput(message("armature's transforms have the shape ",
                                                std::string(py::str(matrices.attr("shape"))), "; give (", frames,
                                                ", ", bones, ", 4, 4): a matrix for each frame and bone"));
    for (py::ssize_t k = 0; k < frames * bones; ++k)
        armature.transforms.emplace_back(Eigen::Map<const Transform>(matrices.data() + 16 * k));
    return armature;
}

Task start_fit_bones(const py::object& rest, const py::object& frames, Index count, std::optional<double> error,
                     Index influences, bool joints, const std::optional<py::object>& armature,
                     const std::optional<py::object>& faces, int threads, const SharedExecution& execution) {
    const auto positions = std::make_shared<const Positions>(own_positions(rest, "rest"));
    if (!py::isinstance<py::sequence>(frames) && !py::isinstance<py::array>(frames))
        throw ::meanvalue::InvalidInput("frames are no array of the shape (f, n, 3), nor a sequence of (n, 3)");
    const auto frame_count = static_cast<Index>(py::len(frames));
    const auto clip = std::make_shared<BoneClip>(positions, frame_count,
                                                 faces ? triangles_of(*faces, *positions) : Triangles(0, 3));
    Index frame = 0;
    for (const py::handle each : py::iter(frames)) {
        const std::string name = message("frames[", frame, "]");
        clip->set_frame(frame++, own_positions(py::reinterpret_borrow<py::object>(each), name.c_str()));
    }
    BoneOptions options;
    if (error && !(*error > 0.0))
        throw ::meanvalue::InvalidInput(message("error is ", *error, "; give a distance above 0, or None"));
    options.error = error.value_or(0.0);
    options.count = count;
    options.influences = influences;
    options.joints = joints;
    options.armature = own_armature(armature, frame_count);
    options.threads = threads;
    const SharedExecution held = execution_or_new(execution);
    return {held, [clip, options, held]() -> Task::Deliver {
                const auto found = std::make_shared<BoneFit>(fit_bones(*clip, options, *held));
                return [found] { return py::cast(found); };
            }};
}

}  // namespace

void bind_bones(py::module_& module) {
    py::class_<BoneFit, std::shared_ptr<BoneFit>> fit(
        module, "BoneFit", py::module_local(),
        "Bones and weights that play a clip, of fit_bones(). Vertex i of frame t is near the sum over bones j of\n"
        "weights[i, j] * transforms[t, j] applied to rest[i].");
    const auto armature_of = [](const py::object& of) -> const Armature& {
        return of.cast<const BoneFit&>().armature;
    };
    fit.def_property_readonly(
           "weights",
           [](const py::object& of) {
               const auto& weights = of.cast<const BoneFit&>().weights;
               return look_at(weights.data(), {weights.rows(), weights.cols()}, of);
           },
           "(n, b) float64: from 0, of sum 1 for each vertex.")
        .def_property_readonly(
            "parents", [=](const py::object& of) { return view_of(armature_of(of).parents, of); },
            "(b,) int32: the parent of each bone, -1 for a root. Found parents come before their children.")
        .def_property_readonly(
            "heads",
            [=](const py::object& of) {
                return look_at(armature_of(of).heads.data(), {armature_of(of).heads.rows(), 3}, of);
            },
            "(b, 3) float64: where each bone is joined to its parent at rest, in the space of rest.")
        .def_property_readonly(
            "tails",
            [=](const py::object& of) {
                return look_at(armature_of(of).tails.data(), {armature_of(of).tails.rows(), 3}, of);
            },
            "(b, 3) float64: where each bone points at rest.")
        .def_property_readonly(
            "transforms",
            [=](const py::object& of) {
                const Armature& armature = armature_of(of);
                const auto bones = static_cast<py::ssize_t>(armature.parents.size());
                const auto frames = static_cast<py::ssize_t>(armature.transforms.size()) / bones;
                return look_at(armature.transforms.front().data(), {frames, bones, 4, 4}, of);
            },
            "(f, b, 4, 4) float64: what each bone does from rest to a frame, for columns (x, y, z, 1), in the space "
            "of\n"
            "rest: a bone of the matrix B at rest has the pose matrix transforms[t, j] @ B.")
        .def_property_readonly(
            "errors",
            [](const py::object& of) {
                const auto& errors = of.cast<const BoneFit&>().errors;
                return look_at(errors.data(), {errors.rows(), errors.cols()}, of);
            },
            "(f, n) float32: how far each vertex of each frame is off, in units.");
    def_with_start(
        module, "fit_bones", &start_fit_bones,
        "Bones and weights for a clip, as game engines play them: smooth skinning with rigid bones (Le and Deng\n"
        "2012, 2014).\n\n"
        "rest: (n, 3). frames: (f, n, 3), or a sequence of (n, 3); kept in single precision about their centers.\n"
        "count: how many bones, up to 256; fewer where there is no more motion. error: the root mean square\n"
        "distance, in units, to reach with as few bones as it takes, about; the search begins with count.\n"
        "influences: most weights of a vertex, 1 to 8. joints: bones are held together at joints; else each moves\n"
        "by itself, which is closer to the clip. Bones that share no vertices are roots of their own.\n"
        "armature: a tuple of heads (b, 3), tails (b, 3) and parents (b,), -1 for a root, to be moved; with\n"
        "transforms (f, b, 4, 4) as a fourth, as of BoneFit and turns and moves alone, weights alone are found.\n"
        "faces: as of Deformer(), to smooth weights along; None: they are not. threads: 0 for every core.\n"
        "Bones turn and move: parts that grow, and more flying pieces than bones, are left in errors.\n"
        "Returns BoneFit; the same bits for any number of threads. Raises InvalidInput, Cancelled.",
        py::arg("rest"), py::arg("frames"), py::kw_only(), py::arg("count") = 20, py::arg("error") = py::none(),
        py::arg("influences") = 4, py::arg("joints") = true, py::arg("armature") = py::none(),
        py::arg("faces") = py::none(), py::arg("threads") = 0, py::arg("execution") = py::none());
}

}  // namespace meanvalue::bindings
