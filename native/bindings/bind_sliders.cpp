#include <pybind11/stl.h>

#include <algorithm>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/sliders/slider_fit.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

/// What Python sees of one frame, or of many with a leading axis.
struct SliderValues {
    py::array_t<double> values;
    py::array_t<double> transform;
    py::array_t<double> residuals;
    py::array_t<bool> outliers;
};

SliderValues arrays_of(const std::vector<SliderSolution>& frames, bool is_sequence) {
    const auto count = static_cast<py::ssize_t>(frames.size());
    const auto shapes = static_cast<py::ssize_t>(frames.front().values.size());
    const auto anchors = static_cast<py::ssize_t>(frames.front().outliers.size());
    const auto shape = [&](std::initializer_list<py::ssize_t> rest) {
        std::vector<py::ssize_t> whole = rest;
        if (is_sequence) whole.insert(whole.begin(), count);
        return whole;
    };
    SliderValues result{py::array_t<double>(shape({shapes})), py::array_t<double>(shape({4, 4})),
                        py::array_t<double>(shape({anchors, 3})), py::array_t<bool>(shape({anchors}))};
    for (py::ssize_t f = 0; f < count; ++f) {
        const SliderSolution& frame = frames[f];
        std::copy(frame.values.begin(), frame.values.end(), result.values.mutable_data() + f * shapes);
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> transform(result.transform.mutable_data() + 16 * f);
        transform.setIdentity();
        transform.topLeftCorner<3, 3>() = frame.rotation;
        transform.topRightCorner<3, 1>() = frame.translation;
        Eigen::Map<Positions>(result.residuals.mutable_data() + 3 * anchors * f, anchors, 3) = frame.residuals;
        std::transform(frame.outliers.begin(), frame.outliers.end(), result.outliers.mutable_data() + anchors * f,
                       [](char flag) { return flag != 0; });
    }
    return result;
}

/// One number for all shapes, or one for each.
std::vector<double> own_bounds(const py::object& bounds, std::size_t shapes, const char* name) {
    const py::array array = array_or_nothing(bounds);
    if (!array || array.ndim() > 0) return as_numbers(bounds, name);
    return std::vector<double>(shapes, as_numbers(array.attr("reshape")(1), name)[0]);
}

std::shared_ptr<SliderFit> make_fit(const py::object& rest, const py::object& shapes, const py::object& anchors,
                                    const py::object& lower, const py::object& upper, bool can_move, int threads) {
    std::vector<SharedPositions> owned;
    for (const py::handle shape : py::iter(shapes)) {
        const std::string name = message("shapes[", owned.size(), "]");
        owned.push_back(
            share(PositionsArray(py::reinterpret_borrow<py::object>(shape), name.c_str()).view(), name.c_str()));
    }
    SliderBinding binding(PositionsArray(rest, "rest").view(), owned, as_indices(anchors, "anchors", "vertex"));
    binding.lower = own_bounds(lower, owned.size(), "lower");
    binding.upper = own_bounds(upper, owned.size(), "upper");
    binding.can_move = can_move;
    binding.threads = threads;
    return beside(std::make_shared<Execution>(), [&] { return std::make_shared<SliderFit>(binding); });
}

Task start_solve(const std::shared_ptr<SliderFit>& fit, const py::object& targets,
                 const std::optional<py::object>& weights, const std::optional<py::object>& start, bool steady,
                 const SharedExecution& execution) {
    SliderOptions options;
    options.steady = steady;
    if (weights) options.weights = as_numbers(*weights, "weights");
    if (start) options.start = as_numbers(*start, "start");
    const Positions owned = PositionsArray(targets, "targets").view();
    const SharedExecution held = execution_or_new(execution);
    return {held, [fit, options, owned, held]() -> Task::Deliver {
                const std::vector<SliderSolution> frames{fit->solve(owned, options, *held)};
                return [frames] { return py::cast(arrays_of(frames, false)); };
            }};
}

Task start_solve_sequence(const std::shared_ptr<SliderFit>& fit, const py::object& targets,
                          const std::optional<py::object>& weights, const SharedExecution& execution) {
    const FloatArray array = as_floats(targets, "targets", 3, "an array of shape (frames, anchors, 3)");
    if (array.shape(2) != 3) {
        throw ::meanvalue::InvalidInput(
            message("targets has ", array.shape(2), " coordinates; give an array of shape (frames, anchors, 3)"));
    }
    std::vector<Positions> frames;
    frames.reserve(static_cast<std::size_t>(array.shape(0)));
    for (py::ssize_t f = 0; f < array.shape(0); ++f) {
        frames.emplace_back(Eigen::Map<const Positions>(array.data() + f * array.shape(1) * 3, array.shape(1), 3));
    }
    std::vector<double> numbers;
    if (weights) {
        const FloatArray given = as_floats(*weights, "weights", 2, "an array of shape (frames, anchors)");
        if (given.shape(0) != array.shape(0) || given.shape(1) != array.shape(1)) {
            throw ::meanvalue::InvalidInput(message("weights has the shape (", given.shape(0), ", ", given.shape(1),
                                                    "), but targets are of ", array.shape(0), " frames and ",
                                                    array.shape(1), " anchors; give one for each"));
        }
        numbers.assign(given.data(), given.data() + given.size());
    }
    const SharedExecution held = execution_or_new(execution);
    return {held, [fit, frames, numbers, held]() -> Task::Deliver {
                const std::vector<SliderSolution> solved = fit->solve_sequence(frames, numbers, *held);
                return [solved] { return py::cast(arrays_of(solved, true)); };
            }};
}

}  // namespace

void bind_sliders(py::module_& module) {
    py::class_<SliderValues>(module, "SliderValues", py::module_local(),
                             "Values of shape keys that SliderFit found; with a leading axis for frames.")
        .def_readonly("values", &SliderValues::values, "(s,) float64: one for each shape, within its bounds.")
        .def_readonly("transform", &SliderValues::transform,
                      "(4, 4) float64: the rigid motion of the whole, from the mixed shape to the targets.")
        .def_readonly("residuals", &SliderValues::residuals,
                      "(k, 3) float64: targets minus what was found; NaN where a target is missing.")
        .def_readonly("outliers", &SliderValues::outliers, "(k,) bool: targets that were not followed.");

    py::class_<SliderFit, std::shared_ptr<SliderFit>> fit(
        module, "SliderFit", py::module_local(),
        "Values of shape keys from the places of a few vertices: of handles, or of markers on a face.\n\n"
        "Shapes are mixed linearly, as Blender does. Few values differ from rest: each has a prior variance of its\n"
        "own, estimated with the noise of the targets (sparse Bayesian learning, Tipping 2001).");
    fit.def(py::init(&make_fit), py::arg("rest"), py::arg("shapes"), py::arg("anchors"), py::kw_only(),
            py::arg("lower") = 0.0, py::arg("upper") = 1.0, py::arg("can_move") = true, py::arg("threads") = 0,
            "rest: (n, 3). shapes: (s, n, 3), or a sequence of (n, 3): the mesh with one key alone at value 1.\n"
            "anchors: (k,) vertex numbers, three or more (one, if the whole can't move).\n"
            "lower, upper: bounds of the values, one number or (s,).\n"
            "can_move: whether a rigid motion of the whole is found as well, as of a head.\n"
            "threads: of solve_sequence(), 0 for every core; results do not depend on it.\n"
            "Raises InvalidInput that names what is wrong with which shape or anchor.");
    def_with_start(
        fit, "solve", &start_solve,
        "Values for one frame.\n\n"
        "targets: (k, 3), NaN where one is missing; three or more are there (one, if the whole can't\n"
        "move). weights: (k,) from 0 on, one over the variance of a target, up to a factor; None: all 1.\n"
        "start: (s,) values to begin with; None: rest. steady: every target is followed, and values change\n"
        "no faster than targets, as dragging a handle needs; they are less sparse.\n"
        "Returns SliderValues. Raises InvalidInput, Cancelled.",
        py::arg("targets"), py::arg("weights") = py::none(), py::kw_only(), py::arg("start") = py::none(),
        py::arg("steady") = false, py::arg("execution") = py::none());
    def_with_start(fit, "solve_sequence", &start_solve_sequence,
                   "Values for the frames of one motion, smooth in time as far as they change in it.\n\n"
                   "targets: (f, k, 3), NaN where one is missing. Frames with too few take theirs from those beside\n"
                   "them. weights: (f, k) as of solve(). Returns SliderValues with a leading axis of f.\n"
                   "Raises InvalidInput, Cancelled.",
                   py::arg("targets"), py::arg("weights") = py::none(), py::kw_only(),
                   py::arg("execution") = py::none());
    fit.def_property_readonly(
           "unseen", [](const SliderFit& of) { return py::tuple(py::cast(of.unseen())); },
           "tuple of int: shapes that move no anchor beyond a rigid motion; they stay at rest.")
        .def_property_readonly(
            "alike", [](const SliderFit& of) { return py::tuple(py::cast(of.alike())); },
            "tuple of (int, int): shapes that move the anchors alike, so that targets can't tell them apart.");
}

}  // namespace meanvalue::bindings
