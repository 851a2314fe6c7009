#include <Eigen/Core>
#include <string>

#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/thread_pool.h"

namespace {

std::string compiler() {
#if defined(__clang__)
    return "Clang " __clang_version__;
#elif defined(__GNUC__)
    return "GCC " __VERSION__;
#elif defined(_MSC_FULL_VER)
    return "MSVC " + std::to_string(_MSC_FULL_VER);
#else
    return "unknown";
#endif
}

pybind11::dict build_info() {
    pybind11::dict info;
    info["compiler"] = compiler();
    info["eigen"] = std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                    std::to_string(EIGEN_MINOR_VERSION);
    info["instructions"] = meanvalue::has_avx2_and_fma() ? "AVX2 and FMA" : "portable";
    info["threads"] = meanvalue::thread_count(0);
    return info;
}

}  // namespace

PYBIND11_MODULE(meanvalue, module) {
    module.doc() =
        "Mean-value geometry encoding (Kraevoy and Sheffer): a rotation-invariant description of each vertex by "
        "its neighbors, from which a mesh is rebuilt when a few anchor vertices move.";
    module.attr("__version__") = MEANVALUE_VERSION;
    module.def(
        "build_info", &build_info,
        "How this module was built and what it uses here, for reports of bugs.\n\n"
        "Returns a dict: compiler (str), eigen (str, its version), instructions (str: those of inner loops that\n"
        "are not bound as portable, \"AVX2 and FMA\" where the processor has them, else \"portable\") and\n"
        "threads (int: as many as a call without `threads` may use).");
    meanvalue::pin_eigen_cache_sizes();
    meanvalue::prepare_thread();
    // No thread may run on while the process takes its libraries down.
    pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(
        &meanvalue::bindings::cancel_tasks, pybind11::call_guard<pybind11::gil_scoped_release>()));
    meanvalue::bindings::bind_execution(module);
    meanvalue::bindings::bind_task(module);
    meanvalue::bindings::bind_encoding(module);
    meanvalue::bindings::bind_reports(module);
    meanvalue::bindings::bind_deformer(module);
    meanvalue::bindings::bind_morph(module);
    meanvalue::bindings::bind_bones(module);
    meanvalue::bindings::bind_follower(module);
    meanvalue::bindings::bind_sliders(module);
    meanvalue::bindings::bind_surface(module);
    meanvalue::bindings::bind_transfer(module);
#ifdef MEANVALUE_WITH_REFERENCE
    meanvalue::bindings::bind_baselines(module);
#endif
}
