#include <Eigen/Core>

#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/detached_job.h"

PYBIND11_MODULE(meanvalue, module) {
    module.doc() =
        "Mean-value geometry encoding (Kraevoy and Sheffer): a rotation-invariant description of each vertex by "
        "its neighbours, from which a mesh is rebuilt when a few anchor vertices move.";
    module.attr("__version__") = MEANVALUE_VERSION;
    // Eigen divides products by the caches that it finds, and with them the sums: the same bits on every processor.
    Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 2 << 20);
    // No thread may run on while the process takes its libraries down.
    const auto stop_all = [] {
        meanvalue::bindings::cancel_tasks();
        meanvalue::wait_for_detached();
    };
    pybind11::module_::import("atexit").attr("register")(
        pybind11::cpp_function(stop_all, pybind11::call_guard<pybind11::gil_scoped_release>()));
    meanvalue::bindings::bind_execution(module);
    meanvalue::bindings::bind_task(module);
    meanvalue::bindings::bind_encoding(module);
    meanvalue::bindings::bind_deformer(module);
    meanvalue::bindings::bind_morph(module);
    meanvalue::bindings::bind_baselines(module);
}
