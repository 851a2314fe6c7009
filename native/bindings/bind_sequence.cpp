#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/sequence/run_plan.h"
#include "meanvalue/sequence/sequence.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;
// Frames that on_frame waits for at most, in chunks for each thread: what is kept of them is most of the memory.
constexpr std::int64_t kChunksOfBlock = 2;

struct Call {
    Trajectories trajectories;
    SequenceOptions options;
};

/// @param targets (frames, anchors, 3). @param weights (frames, anchors). @throws InvalidInput.
Trajectories own_trajectories(const py::object& targets, const std::optional<py::object>& weights) {
    Trajectories trajectories;
    const FloatArray target_array = as_floats(targets, "targets", 3, "an array of shape (frames, anchors, 3)");
    if (target_array.shape(2) != 3) {
        throw ::meanvalue::InvalidInput(message("targets has the shape (", target_array.shape(0), ", ",
                                                target_array.shape(1), ", ", target_array.shape(2),
                                                "); give (frames, anchors, 3)"));
    }
    for (const int axis : {0, 1}) {
        if (target_array.shape(axis) > std::numeric_limits<Index>::max()) {
            throw ::meanvalue::InvalidInput(
                message("targets has ", target_array.shape(axis), axis == 0 ? " frames" : " anchors", ", too many"));
        }
    }
    trajectories.frame_count = static_cast<Index>(target_array.shape(0));
    trajectories.anchor_count = static_cast<Index>(target_array.shape(1));
    trajectories.targets.assign(target_array.data(), target_array.data() + target_array.size());
    if (weights) {
        const FloatArray weight_array = as_floats(*weights, "weights", 2, "an array of shape (frames, anchors)");
        if (weight_array.shape(0) != target_array.shape(0) || weight_array.shape(1) != target_array.shape(1)) {
            throw ::meanvalue::InvalidInput(message("weights has the shape (", weight_array.shape(0), ", ",
                                                    weight_array.shape(1), "), but targets are of ",
                                                    trajectories.frame_count, " frames and ",
                                                    trajectories.anchor_count, " anchors"));
        }
        trajectories.weights.assign(weight_array.data(), weight_array.data() + weight_array.size());
    }
    return trajectories;
}

Call own_call(const py::object& targets, const std::optional<py::object>& weights,
              const std::optional<std::pair<Index, Index>>& frames, Index chunk, Index overlap,
              std::vector<Index> kept, std::optional<double> tolerance, int max_iterations, int threads) {
    Call call;
    call.trajectories = own_trajectories(targets, weights);
    call.options.tolerance = tolerance;
    call.options.max_iterations = max_iterations;
    call.options.frames = frames;
    call.options.chunk = chunk;
    call.options.overlap = overlap;
    call.options.kept = std::move(kept);
    call.options.threads = threads;
    return call;
}

/// In blocks, each of which is handed over frame by frame before the next one is begun.
std::shared_ptr<Sequence> solve_and_hand_over(const Deformer& deformer, const Call& call, const py::object& on_frame,
                                              const SharedExecution& execution) {
    const auto [begin, end] = call.options.frames.value_or(std::pair<Index, Index>{0, call.trajectories.frame_count});
    auto whole = std::make_shared<Sequence>();
    whole->first = begin;
    whole->vertex_count = deformer.report().vertex_count;
    SequenceOptions options = call.options;
    const std::int64_t chunk = std::max<Index>(options.chunk, 1);
    const std::int64_t block = kChunksOfBlock * std::int64_t{std::max(1, thread_count(options.threads))} * chunk;
    Index from = begin;
    do {  // once at least, so that what is wrong is told
        const auto to = static_cast<Index>(std::min<std::int64_t>(end, (from / block + 1) * block));
        options.frames = {from, to};
        const double count = std::max<Index>(1, end - begin);
        options.progress = {(from - begin) / count, (to - begin) / count};
        const auto part = beside(execution, [&] {
            return std::make_shared<Sequence>(solve_sequence(deformer, call.trajectories, options, *execution));
        });
        const py::object owner = py::cast(part);
        for (Index frame = from; frame < to; ++frame) {
            const auto numbers = static_cast<std::size_t>(part->vertex_count) * 3;
            py::array_t<float> shape({static_cast<py::ssize_t>(part->vertex_count), py::ssize_t{3}},
                                     part->vertices.get() + static_cast<std::size_t>(frame - from) * numbers, owner);
            shape.attr("flags").attr("writeable") = false;
            on_frame(frame, shape);
        }
        whole->energies.insert(whole->energies.end(), part->energies.begin(), part->energies.end());
        whole->iterations.insert(whole->iterations.end(), part->iterations.begin(), part->iterations.end());
        whole->converged.insert(whole->converged.end(), part->converged.begin(), part->converged.end());
        whole->snaps.insert(whole->snaps.end(), part->snaps.begin(), part->snaps.end());
        whole->failures.insert(whole->failures.end(), part->failures.begin(), part->failures.end());
        from = to;
        execution->check();  // a callback may have cancelled it
    } while (from < end);
    return whole;
}

std::shared_ptr<Sequence> solve_frames(const Deformer& deformer, const py::object& targets,
                                       const std::optional<py::object>& weights,
                                       const std::optional<std::pair<Index, Index>>& frames, Index chunk,
                                       Index overlap, std::vector<Index> kept, std::optional<double> tolerance,
                                       int max_iterations, const std::optional<py::object>& on_frame, int threads,
                                       const SharedExecution& execution) {
    const Call call =
        own_call(targets, weights, frames, chunk, overlap, std::move(kept), tolerance, max_iterations, threads);
    const SharedExecution held = execution_or_new(execution);
    if (on_frame) return solve_and_hand_over(deformer, call, *on_frame, held);
    return beside(held, [&] {
        return std::make_shared<Sequence>(solve_sequence(deformer, call.trajectories, call.options, *held));
    });
}

Task start_frames(const std::shared_ptr<Deformer>& deformer, const py::object& targets,
                  const std::optional<py::object>& weights, const std::optional<std::pair<Index, Index>>& frames,
                  Index chunk, Index overlap, std::vector<Index> kept, std::optional<double> tolerance,
                  int max_iterations, int threads, const SharedExecution& execution) {
    const auto call = std::make_shared<Call>(
        own_call(targets, weights, frames, chunk, overlap, std::move(kept), tolerance, max_iterations, threads));
    const SharedExecution held = execution_or_new(execution);
    return {held, [deformer, call, held]() -> Task::Deliver {
                const auto sequence =
                    std::make_shared<Sequence>(solve_sequence(*deformer, call->trajectories, call->options, *held));
                return [sequence] { return py::cast(sequence); };
            }};
}

std::vector<Index> find_told_snaps(const py::object& shapes, const py::object& targets, double size,
                                   const std::optional<py::object>& weights) {
    Trajectories trajectories = own_trajectories(targets, weights);
    const FloatArray array = as_floats(shapes, "shapes", 3, "an array of shape (frames, vertices, 3)");
    if (array.shape(2) != 3 || array.shape(0) != trajectories.frame_count) {
        throw ::meanvalue::InvalidInput(message("shapes has the shape (", array.shape(0), ", ", array.shape(1), ", ",
                                                array.shape(2), "); give (frames, vertices, 3) of the ",
                                                trajectories.frame_count, " frames that targets has"));
    }
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (!(size > 0.0) || !std::all_of(array.data(), array.data() + array.size(), is_finite))
        throw ::meanvalue::InvalidInput("give shapes of finite numbers, and a positive size");
    for (std::size_t k = 0; k < trajectories.targets.size(); ++k) {
        const bool counts = trajectories.weights.empty() || trajectories.weights[k / 3] > 0.0;
        if (counts && !is_finite(trajectories.targets[k]))
            throw ::meanvalue::InvalidInput("targets are not finite where their weight is not 0; leave them out");
    }
    std::vector<float> points(array.data(), array.data() + array.size());
    std::vector<float*> frames;
    frames.reserve(trajectories.frame_count);
    for (Index frame = 0; frame < trajectories.frame_count; ++frame)
        frames.push_back(points.data() + 3 * array.shape(1) * frame);
    std::vector<Index> vertices(array.shape(1));
    std::iota(vertices.begin(), vertices.end(), 0);
    std::vector<AnchorOfRegion> anchors;
    anchors.reserve(trajectories.anchor_count);
    for (Index k = 0; k < trajectories.anchor_count; ++k)
        anchors.push_back({k, k});
    const RunPaths paths(frames, std::move(vertices), std::vector<char>(frames.size(), 1));
    std::vector<Index> told;
    for (const Snap& snap : paths.find_snaps(paths.limits(trajectories, anchors, 0, size), Execution())) {
        if (snap.length >= kTold * size) told.push_back(snap.frame);
    }
    return told;
}

py::array_t<float> sequence_vertices(const py::object& self) {
    const auto& sequence = self.cast<const Sequence&>();
    const py::ssize_t frames = sequence.vertices ? sequence.frame_count : 0;
    py::array_t<float> array({frames, static_cast<py::ssize_t>(sequence.vertex_count), py::ssize_t{3}},
                             sequence.vertices.get(), self);
    array.attr("flags").attr("writeable") = false;
    return array;
}

}  // namespace

void bind_sequence(py::module_& module, py::class_<Deformer, std::shared_ptr<Deformer>>& deformer) {
    py::class_<Sequence, std::shared_ptr<Sequence>>(module, "Sequence", py::module_local(),
                                                    "The result of solving many frames.")
        .def_readonly("first", &Sequence::first, "int: number of the first frame in the clip.")
        .def_property_readonly("vertices", &sequence_vertices,
                               "(f, n, 3) float32, read-only: a view that keeps the sequence alive. No frames where\n"
                               "on_frame took them.")
        .def_property_readonly(
            "energies", [](const py::object& self) { return view_of(self.cast<const Sequence&>().energies, self); },
            "(f,) float64: as Solution.energy, before snaps are spread and runs fade; NaN where it failed.")
        .def_property_readonly(
            "iterations",
            [](const py::object& self) { return view_of(self.cast<const Sequence&>().iterations, self); },
            "(f,) int32: of all stages of the solve.")
        .def_property_readonly(
            "converged",
            [](const py::object& self) {
                return view_of(self.cast<const Sequence&>().converged, self).attr("view")("bool");
            },
            "(f,) bool: a minimum is near, as Solution.converged.")
        .def_property_readonly(
            "snaps", [](const Sequence& sequence) { return py::tuple(py::cast(sequence.snaps)); },
            "tuple of int, ascending: frames that the shape snaps at from the frame before, by 2 % of the diagonal\n"
            "or more. Frames beside are spread over that; a key between both keeps the way.")
        .def_property_readonly(
            "errors",
            [](const Sequence& sequence) {
                py::list errors;
                for (const FrameFailure& failure : sequence.failures)
                    errors.append(py::make_tuple(failure.frame, failure.message));
                return py::tuple(errors);
            },
            "tuple of (frame, message): frames that could not be solved. They hold the shape of the last that\n"
            "could, or of rest where none could before.");

    module.def(
        "find_snaps",
        [](const py::object& shapes, const py::object& targets, double size,
           const std::optional<py::object>& weights) {
            return py::tuple(py::cast(find_told_snaps(shapes, targets, size, weights)));
        },
        py::arg("shapes"), py::arg("targets"), py::arg("size"), py::kw_only(), py::arg("weights") = py::none(),
        "The frames that shapes snap at, by the rule of Sequence.snaps.\n\n"
        "shapes: (f, n, 3) of consecutive frames, as they were solved; some vertices of each are enough.\n"
        "targets, weights: (f, k, 3) and (f, k), as of solve_sequence(), of the same frames.\n"
        "size: the diagonal of the rest shape's bounding box.\n"
        "Eight frames to either side are compared with a step. Near the ends there are fewer, and nothing is told\n"
        "of the first two steps and the last two.\n"
        "Returns a tuple of int, ascending: counted from the first of these frames.\n"
        "Raises InvalidInput for arrays of another form and numbers that are not finite.");
    const SequenceOptions defaults;
    deformer
        .def(
            "solve_sequence", &solve_frames, py::arg("targets"), py::kw_only(), py::arg("weights") = py::none(),
            py::arg("frames") = py::none(), py::arg("chunk") = defaults.chunk, py::arg("overlap") = defaults.overlap,
            py::arg("kept") = defaults.kept, py::arg("tolerance") = py::none(),
            py::arg("max_iterations") = defaults.max_iterations, py::arg("on_frame") = py::none(),
            py::arg("threads") = defaults.threads, py::arg("execution") = py::none(),
            "Solve every frame of a clip (section 4.2 of the paper: anchors follow trajectories).\n\n"
            "targets: (f, k, 3), the whole clip, each frame as for solve().\n"
            "weights: (f, k) from 0 to 1, or None: what the strength of each soft anchor is multiplied with in\n"
            "each frame. At 0 it is free, and its target may be anything, also NaN; hard anchors have 1. The spring\n"
            "is gone then; rows of the energy keep the weights that bind gave them beside it. Anchors far stiffer\n"
            "than a strength of 1e5 go slowly.\n"
            "frames: (begin, end) of those wanted, None: all.\n"
            "chunk: frames are solved in runs of so many, counted from the first of the clip, each from the frame\n"
            "before it, the first of a run from rest. overlap: each run but the first begins so many frames\n"
            "earlier, over which the one before it fades into it, so that nothing jumps where two runs came to\n"
            "different minima. Where the shape snaps, as where a minimum ceases to be, that is spread over some\n"
            "frames, so many to either side at most, along shapes of little energy; at 0 nothing is spread.\n"
            "kept: frames, ascending, such as an artist's keys, that no snap beside them is spread over.\n"
            "tolerance, max_iterations: as of solve(). threads: 0 for every core; runs are solved side by side.\n"
            "A frame's bits depend on targets, weights, chunk and overlap alone: neither on the frames wanted nor\n"
            "on the number of threads.\n"
            "on_frame: called with (frame, (n, 3) float32 read-only) for each in order, on the calling thread,\n"
            "some chunks at a time; the frames are then not kept, and memory does not grow with their number.\n"
            "Returns a Sequence. A frame that can't be solved is told in Sequence.errors and does not end the rest.\n"
            "Raises InvalidInput for arrays of another form and options out of range, Cancelled.")
        .def("start_solve_sequence", &start_frames, py::arg("targets"), py::kw_only(),
             py::arg("weights") = py::none(), py::arg("frames") = py::none(), py::arg("chunk") = defaults.chunk,
             py::arg("overlap") = defaults.overlap, py::arg("kept") = defaults.kept,
             py::arg("tolerance") = py::none(), py::arg("max_iterations") = defaults.max_iterations,
             py::arg("threads") = defaults.threads, py::arg("execution") = py::none(),
             "As solve_sequence(), beside the interpreter. Returns a Task whose result is the Sequence.\n\n"
             "Arrays are copied first. Raises InvalidInput for arrays of another form.");
}

}  // namespace meanvalue::bindings
