#include <pybind11/stl.h>

#include <algorithm>
#include <mutex>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue::bindings {
namespace {

using SharedExecution = std::shared_ptr<Execution>;

Method method_from_name(const std::string& name) {
    if (name == "fast") return Method::kFast;
    if (name == "paper") return Method::kPaper;
    if (name == "full") return Method::kFull;
    throw ::meanvalue::InvalidInput(message("method is '", name, "'; this version knows 'fast', 'paper' and 'full'"));
}

LooseRule loose_rule_from_name(const std::string& name) {
    if (name == "stay") return LooseRule::kStay;
    if (name == "follow") return LooseRule::kFollow;
    throw ::meanvalue::InvalidInput(message("loose is '", name, "'; this version knows 'stay' and 'follow'"));
}

void give_anchors(const py::object& anchors, const std::optional<py::object>& handles, std::optional<double> rigidity,
                  const std::optional<py::object>& strengths, Index border,
                  const std::optional<py::object>& stiffness, Binding& binding) {
    if (border < 0) throw ::meanvalue::InvalidInput("border is negative; give 0 or more");
    binding.anchors = as_indices(anchors, "anchors", "vertex");
    const auto count = static_cast<Index>(binding.anchors.size());
    if (border > count) {
        throw ::meanvalue::InvalidInput(message("border is ", border, ", but there are ", count,
                                                " anchors; give how many of the last of them are a soft border"));
    }
    if (border > 0) {
        binding.is_border.assign(count, 0);
        std::fill(binding.is_border.end() - border, binding.is_border.end(), 1);
    }
    if (handles) {
        binding.handles = as_indices(*handles, "handles", "handle");
        if (binding.handles.empty() && !binding.anchors.empty()) {
            throw ::meanvalue::InvalidInput(
                "handles is empty, but there are anchors; give one number for each, or None");
        }
    }
    binding.rigidity = rigidity;
    if (strengths) {
        binding.strengths = as_numbers(*strengths, "strengths");
        if (binding.strengths.empty() && !binding.anchors.empty()) {
            throw ::meanvalue::InvalidInput(
                "strengths is empty, but there are anchors; give one number for each, or None");
        }
    }
    if (stiffness) {
        binding.stiffness = as_numbers(*stiffness, "stiffness");
        if (binding.stiffness.empty() && binding.vertices->rows() > 0)
            throw ::meanvalue::InvalidInput("stiffness is empty; give one number for each vertex, or None");
    }
}

/// The deformer that can be used while another is being bound.
struct Early {
    std::mutex mutex;
    std::shared_ptr<Deformer> deformer;

    /// It does not wait: in a forked child the lock may be held for ever.
    std::shared_ptr<Deformer> get() {
        const std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
        return lock ? deformer : nullptr;
    }
    void set(std::shared_ptr<Deformer> other) {
        const std::lock_guard<std::mutex> lock(mutex);
        deformer.swap(other);
    }
};

Task start_bind_of(Binding binding, const std::shared_ptr<Deformer>& earlier, bool has_early,
                   const SharedExecution& execution) {
    const SharedExecution held = execution_or_new(execution);
    const auto early = has_early ? std::make_shared<Early>() : nullptr;
    const auto work = [binding = std::move(binding), earlier, early, held]() -> Task::Deliver {
        wait_for_cancelled_tasks(*held);
        std::function<void(std::shared_ptr<Deformer>)> when_coarse;
        if (early) when_coarse = [&](std::shared_ptr<Deformer> coarse) { early->set(std::move(coarse)); };
        const auto forget = [](Early* of) {
            if (of != nullptr) of->set(nullptr);
        };
        const std::unique_ptr<Early, decltype(forget)> at_the_end(early.get(), forget);  // also of a failure
        const auto deformer = std::make_shared<Deformer>(binding, *held, earlier.get(), when_coarse);
        return [deformer] { return py::cast(deformer); };
    };
    if (!early) return {held, work};
    return {held, work, [early] { return py::cast(early->get()); }};
}

Task start_bind(const py::object& vertices, const py::object& faces, const py::object& anchors,
                const std::optional<py::object>& roi, const std::optional<py::object>& handles,
                std::optional<double> rigidity, const std::optional<py::object>& strengths, Index border,
                const std::string& loose, const std::string& method, int threads, bool portable,
                const std::optional<py::object>& examples, const std::optional<py::object>& stiffness, bool early,
                const SharedExecution& execution) {
    const auto positions = std::make_shared<const Positions>(own_positions(vertices, "vertices"));
    Binding binding(positions, std::make_shared<const Triangles>(triangles_of(faces, *positions)), {},
                    as_flags(roi, "roi"));
    give_anchors(anchors, handles, rigidity, strengths, border, stiffness, binding);
    binding.loose = loose_rule_from_name(loose);
    binding.method = method_from_name(method);
    binding.threads = threads;
    if (examples) binding.examples = own_shapes(*examples, "examples");
    binding.instructions = portable ? InstructionSet::kPortable : InstructionSet::kFastest;
    return start_bind_of(std::move(binding), nullptr, early, execution);
}

Task start_rebind(const std::shared_ptr<Deformer>& earlier, const py::object& anchors,
                  const std::optional<py::object>& handles, std::optional<double> rigidity,
                  const std::optional<py::object>& strengths, Index border,
                  const std::optional<py::object>& stiffness, bool early, const SharedExecution& execution) {
    Binding binding = earlier->binding_again();
    give_anchors(anchors, handles, rigidity, strengths, border, stiffness, binding);
    return start_bind_of(std::move(binding), earlier, early, execution);
}

SolveOptions solve_options(std::optional<double> tolerance, int max_iterations, bool settle,
                           const std::optional<py::object>& weights, int threads) {
    SolveOptions options;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    options.settle = settle;
    options.threads = threads;
    if (weights) {
        options.weights = as_numbers(*weights, "weights");
        if (options.weights.empty())
            throw ::meanvalue::InvalidInput("weights is empty; give one number for each anchor, or None");
    }
    return options;
}

/// @param solve what is called with the targets, the options and the execution.
template <typename Solve>
Task start_solve_of(const py::object& targets, SolveOptions options, const SharedExecution& execution, Solve solve) {
    const SharedExecution held = execution_or_new(execution);
    return {held,
            [own = std::make_shared<const Positions>(PositionsArray(targets, "targets").view()),
             options = std::move(options), held, solve = std::move(solve)]() -> Task::Deliver {
                const auto solution = std::make_shared<Solution>(solve(*own, options, *held));
                return [solution] { return py::cast(solution); };
            }};
}

std::shared_ptr<const Positions> own_start(const std::optional<py::object>& start) {
    return start ? std::make_shared<const Positions>(PositionsArray(*start, "start").view()) : nullptr;
}

std::optional<PositionsView> view_of(const std::shared_ptr<const Positions>& start) {
    return start ? std::optional<PositionsView>(*start) : std::nullopt;
}

Task start_solve(const std::shared_ptr<Deformer>& deformer, const py::object& targets,
                 const std::optional<py::object>& start, std::optional<double> tolerance, int max_iterations,
                 bool settle, const std::optional<py::object>& weights, int threads,
                 const SharedExecution& execution) {
    return start_solve_of(
        targets, solve_options(tolerance, max_iterations, settle, weights, threads), execution,
        [deformer, own = own_start(start)](const Positions& goal, const SolveOptions& options, Execution& held) {
            return deformer->solve(goal, view_of(own), options, held);
        });
}

/// @return what waits for the Deformer that `start` binds.
template <typename... Arguments>
auto deformer_of(Task (*start)(Arguments...)) {
    return [start](Arguments... arguments) {
        return start(arguments...).result().template cast<std::shared_ptr<Deformer>>();
    };
}

// A draft of so many vertices takes 3 to 13 ms. Below, a look at signals meanwhile is not worth another thread, which
// makes it twice as long while a solve is at work.
constexpr Index kMostOfShortDrafts = 200000;

/// A drag until it is ended.
struct Drag {
    std::shared_ptr<Deformer::Drag> drag;
    bool has_long_drafts;
};

Drag begin_drag(const Deformer& deformer, const std::optional<py::object>& start) {
    const std::shared_ptr<const Positions> own = own_start(start);
    return {std::make_shared<Deformer::Drag>(deformer, view_of(own)),
            deformer.report().vertex_count > kMostOfShortDrafts};
}

Task start_solve_in_drag(const Drag& drag, const py::object& targets, std::optional<double> tolerance,
                         int max_iterations, bool settle, const std::optional<py::object>& weights, int threads,
                         const SharedExecution& execution) {
    if (!drag.drag) throw ::meanvalue::InvalidInput("the drag has ended; begin another with Deformer.drag()");
    return start_solve_of(targets, solve_options(tolerance, max_iterations, settle, weights, threads), execution,
                          [drag](const Positions& goal, const SolveOptions& options, Execution& held) {
                              return drag.drag->solve(goal, options, held);
                          });
}

std::optional<py::array_t<double>> draft_of(const Drag& drag, const py::object& targets) {
    if (!drag.drag) throw ::meanvalue::InvalidInput("the drag has ended; begin another with Deformer.drag()");
    const PositionsArray goal(targets, "targets");
    const Drag held = drag;  // it may be ended meanwhile; NOLINT(performance-unnecessary-copy-initialization)
    const auto execution = std::make_shared<Execution>();
    const auto make = [&] { return held.drag->draft(goal.view(), 1, *execution); };
    std::optional<Positions> draft;
    if (held.has_long_drafts) {
        draft = beside(execution, make);
    } else {
        const py::gil_scoped_release release;
        draft = make();
    }
    if (!draft) return {};
    return to_array(std::move(*draft));
}

}  // namespace

void bind_deformer(py::module_& module) {
    const SolveOptions defaults;
    py::class_<Deformer, std::shared_ptr<Deformer>> deformer(
        module, "Deformer", py::module_local(),
        "A mesh bound to its anchors: expensive to make, cheap to solve again for other targets.");
    const auto def_bind = [](auto&& define, const std::string& text) {
        define(py::arg("vertices"), py::arg("faces"), py::arg("anchors"), py::kw_only(), py::arg("roi") = py::none(),
               py::arg("handles") = py::none(), py::arg("rigidity") = py::none(), py::arg("strengths") = py::none(),
               py::arg("border") = 0, py::arg("loose") = "stay", py::arg("method") = "fast", py::arg("threads") = 0,
               py::arg("portable") = false, py::arg("examples") = py::none(), py::arg("stiffness") = py::none(),
               py::arg("early") = false, py::arg("execution") = py::none(), text.c_str());
    };
    def_bind(
        [&](const auto&... arguments) { deformer.def(py::init(deformer_of(&start_bind)), arguments...); },
        "Bind a mesh.\n\n"
        "vertices: (n, 3) rest positions; anchors: (k,) vertex numbers.\n"
        "faces: (m, 3) int32 triangles, or polygons, which triangulate() splits: (m, k), a list of (k,) of any\n"
        "lengths, or a tuple (offsets, corners) of two arrays, face i with corners[offsets[i]:offsets[i + 1]].\n"
        "roi: (n,) bool, True may move; outside it everything keeps its place. None: every vertex may.\n"
        "handles: (k,) piece numbers from 0: anchors of one piece move rigidly together, so that far turns can\n"
        "be followed along their way. None: anchors joined by edges make a piece.\n"
        "rigidity: how much lengths count, 0 or more; 0 is the paper's energy, None the default of the method.\n"
        "strengths: (k,) float, one for each anchor. inf: met exactly, as all are with None. A finite number\n"
        "0 < s <= 1e9: a soft anchor, a free vertex that a spring pulls to its target, with the energy\n"
        "s |v - target|^2. That is in squared units of the input as the rest of the energy is, so s has no "
        "unit;\n"
        "about 1 is as stiff as the surroundings of one vertex. Divide by the number of a handle's vertices to\n"
        "make it the strength of the handle; to let it give way alike at any resolution, make it weaker as 1 / "
        "n\n"
        "besides, as the energy of the shape is in finer meshes. A part is held by its soft anchors as by hard\n"
        "ones. Method 'fast' only, and inside roi.\n"
        "border: so many of the anchors, the last ones, are soft and only hold the region's border to its rest\n"
        "shape; with loose='follow', a part that has no others follows.\n"
        "loose: what becomes of a part that holds no anchor and lies in the region as a whole. 'stay': it keeps\n"
        "its place. 'follow': it goes along with the surface that is held as a Follower does, bent as clothes\n"
        "are, or rigid; report.carriers tells with which part.\n"
        "method: 'fast' (coarse to fine, to convergence, with rigidity), 'paper' (hierarchical decoding, section\n"
        "3.2; its coarse level by damped Gauss-Newton steps and a Cholesky factor instead of conjugate gradients\n"
        "and bisection) or 'full' (equation 15 to convergence from the rest pose, section 2.3).\n"
        "threads: 0 for every core; results do not depend on it.\n"
        "portable: solve with the instructions that every processor of this architecture has. Slower, with the\n"
        "same bits on all of them, as machines of several kinds need that share frames of one clip.\n"
        "examples: (e, n, 3), or a sequence of (n, 3): shapes that the mesh is known to take, however rotated and\n"
        "moved. The mesh then bends as they show it, each place by its own blend of them. Method 'fast' only. Each\n"
        "must differ from the rest shape and from the others.\n"
        "stiffness: (n,) float factors from 1e-6 to 1e6: how many times as much lengths count around each\n"
        "vertex; None: 1. With 30 along limbs and 1 around joints, limbs bend at their joints. Soft anchors keep\n"
        "their reach: all are stronger by the root of the factors' geometric mean. Method 'fast' only.\n"
        "early: of start_bind(): Task.early can be used meanwhile. It takes some 5 % more memory.\n"
        "Raises InvalidInput that names what is wrong (a vertex with more than 2048 neighbors that may move,\n"
        "among others), TooLittleMemory where the computer has less than a bind takes, SolverFailure, Cancelled.");
    def_bind([&](const auto&... arguments) { module.def("start_bind", &start_bind, arguments...); },
             "As Deformer(), beside the interpreter. Returns a Task whose result is the Deformer.\n\n"
             "Arrays are copied first. Raises InvalidInput for arrays of another form.");
    module.def(
        "deform",
        [type = py::object(deformer)](const py::object& vertices, const py::object& faces, const py::object& anchors,
                                      const py::object& targets, const py::kwargs& as_deformer) {
            py::dict also;
            if (as_deformer.contains("execution")) also["execution"] = as_deformer["execution"];
            return type(vertices, faces, anchors, **as_deformer).attr("solve")(targets, **also);
        },
        py::arg("vertices"), py::arg("faces"), py::arg("anchors"), py::arg("targets"),
        "One pose of a mesh: binds and solves at once.\n\n"
        "vertices, faces, anchors, and all that is given by name: as of Deformer(); targets: as of its solve().\n"
        "Returns a Solution. For other targets of the same anchors, keep a Deformer. Raises as both.");
    def_with_start(
        deformer, "solve", &start_solve,
        "Place every free vertex so that the shape is kept as well as the anchors allow.\n\n"
        "targets: (k, 3), in the order of the anchors, which meet them exactly but for soft ones; at most 1e6\n"
        "bounding-box diagonals from where they rest.\n"
        "start: (n, 3) an earlier solution, from which the shape follows what the anchors have moved since;\n"
        "None for the rest shape. The answer depends on nothing else that was solved; for a row of solves, each\n"
        "from the one before, drag() is faster.\n"
        "tolerance: stop when no vertex moves farther in a step than this share of the bounding-box\n"
        "diagonal of its part at rest; None: 1e-4 for method 'fast' (5e-5 at rigidity 0), 1e-6 for the others.\n"
        "From rest, method 'fast' stops also when the energy falls by less than 50 times it in four steps.\n"
        "max_iterations: the most of each stage of the solve (the whole mesh, and the coarser levels before "
        "it);\n"
        "at the limit, the best shape so far is returned. Solution.all_iterations counts those of all stages.\n"
        "Method 'full', and the coarse level of 'paper', stop also when the energy falls by less than 100\n"
        "times the tolerance in three steps on end.\n"
        "settle: to a tenth of the tolerance, and with a start from rest, unless a rough solve from the start\n"
        "has less energy, which goes on then: for the end of a drag.\n"
        "weights: (k,) from 0 to 1, or None: what the strength of each soft anchor is multiplied with, 1 for\n"
        "hard ones. At 0 it is free, and its target may be anything, also NaN.\n"
        "threads: 0 for as many as the mesh was bound with; results do not depend on it.\n"
        "execution: an Execution by which another thread cancels the solve and sees how far it is.\n"
        "Returns a Solution.\n"
        "Raises InvalidInput, SolverFailure, Cancelled; the deformer stays usable. Threads may solve on one\n"
        "deformer side by side, each with the bits that it has alone.",
        py::arg("targets"), py::kw_only(), py::arg("start") = py::none(), py::arg("tolerance") = py::none(),
        py::arg("max_iterations") = defaults.max_iterations, py::arg("settle") = defaults.settle,
        py::arg("weights") = py::none(), py::arg("threads") = 0, py::arg("execution") = py::none());
    py::class_<Drag> drag(
        module, "Drag", py::module_local(),
        "A row of solves, each from the answer of the one before: by Deformer.drag().\n\n"
        "Method 'fast' goes on with what the solves before have told: an answer depends on them, within the\n"
        "tolerance, and the end of a long flat valley may be left to the next solve (settle leaves nothing). One\n"
        "solve at a time: a second waits.");
    def_with_start(
        drag, "solve", &start_solve_in_drag,
        "As Deformer.solve(), from the last answer. After an exception the next begins where this one did.",
        py::arg("targets"), py::kw_only(), py::arg("tolerance") = py::none(),
        py::arg("max_iterations") = defaults.max_iterations, py::arg("settle") = defaults.settle,
        py::arg("weights") = py::none(), py::arg("threads") = 0, py::arg("execution") = py::none());
    drag.def(
        "draft", &draft_of, py::arg("targets"),
        "What solve() is going to give, in a few milliseconds: (n, 3), hard anchors at their targets, or None\n"
        "where too little is known of such a move.\n\n"
        "targets: as of solve(). Also while start_solve() is at work: to be shown until it is done. It depends\n"
        "on the answers so far, and no solve depends on it. Method 'fast' alone knows of drafts. There are some\n"
        "once a solve has begun at an earlier answer or a start, and none from a settled answer until then.\n"
        "Raises InvalidInput, SolverFailure.");
    drag.def("__enter__", [](const py::object& self) { return self; });
    drag.def(
        "__exit__", [](Drag& self, const py::args&) { self.drag = nullptr; }, "Ends it and frees its memory.");
    deformer.def(
        "drag", &begin_drag, py::arg("start") = py::none(),
        "Begin a row of solves, each from the answer of the one before: with deformer.drag() as drag:\n"
        "drag.solve(targets).\n\n"
        "start: (n, 3) where the first begins; None: at rest. Returns a Drag. Any number may go on side by side.");
    def_with_start(
        deformer, "rebind", &start_rebind,
        "Bind the same mesh to other anchors. Returns a new Deformer; this one stays as it is.\n\n"
        "Mesh, roi, method, threads, portable and loose are those of this one; anchors, handles, rigidity,\n"
        "strengths, border and stiffness as in Deformer(), whose result this has, bit by bit. What does not\n"
        "depend on these is shared:\n"
        "with a handle more or less it takes two thirds of the time. Large handles (more than a 64th of the\n"
        "vertices) that come or go, and parts of the mesh that had no anchor before, take as long as at first.\n"
        "Raises InvalidInput, SolverFailure, Cancelled as Deformer().",
        py::arg("anchors"), py::kw_only(), py::arg("handles") = py::none(), py::arg("rigidity") = py::none(),
        py::arg("strengths") = py::none(), py::arg("border") = 0, py::arg("stiffness") = py::none(),
        py::arg("early") = false, py::arg("execution") = py::none());
    deformer.def_property_readonly("report", &Deformer::report, py::return_value_policy::reference_internal,
                                   "BindReport: what bind found, and what it cost.");
    bind_sequence(module, deformer);
}

}  // namespace meanvalue::bindings
