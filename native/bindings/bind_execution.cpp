#include "bindings/bind.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/execution.h"
#include "meanvalue/common/physical_memory.h"

namespace meanvalue::bindings {

void bind_execution(py::module_& module) {
    py::register_local_exception<InvalidInput>(module, "InvalidInput", PyExc_ValueError);
    py::register_local_exception<SolverFailure>(module, "SolverFailure", PyExc_RuntimeError);
    py::register_local_exception<TooLittleMemory>(module, "TooLittleMemory", PyExc_MemoryError);
    py::register_local_exception<Cancelled>(module, "Cancelled", PyExc_RuntimeError);

    py::class_<Execution, std::shared_ptr<Execution>>(
        module, "Execution", py::module_local(),
        "Cancel and progress of one long operation; every member may be used from any thread.\n\n"
        "Make a new one for each operation: once cancelled, it stays cancelled.")
        .def(py::init<>())
        .def("cancel", &Execution::cancel,
             "Ask the operation to stop. It raises Cancelled within about 100 ms and changes nothing.")
        .def_property_readonly("cancelled", &Execution::cancelled, "bool: cancel() was called.")
        .def_property_readonly("progress", &Execution::progress, "float: share of the current stage, 0 to 1.")
        .def_property_readonly("stage", &Execution::stage, "str: name of the current stage, '' before the first.");
}

}  // namespace meanvalue::bindings
