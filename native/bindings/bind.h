// The parts of the Python module, each bound in a file of its own.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "meanvalue/common/execution.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue::bindings {

namespace py = pybind11;

void bind_execution(py::module_& module);
void bind_task(py::module_& module);
void bind_encoding(py::module_& module);
/// BindReport and Solution, before the classes that return them.
void bind_reports(py::module_& module);
void bind_deformer(py::module_& module);
/// Adds the solving of many frames to the class of Deformer.
void bind_sequence(py::module_& module, py::class_<Deformer, std::shared_ptr<Deformer>>& deformer);
/// Needs the classes of encodings and of Deformer.
void bind_morph(py::module_& module);
void bind_bones(py::module_& module);
void bind_follower(py::module_& module);
void bind_sliders(py::module_& module);
void bind_surface(py::module_& module);
void bind_transfer(py::module_& module);
void bind_baselines(py::module_& module);

/// The caller's Execution, or a fresh one where None was given. Held by the caller: no Python object is touched
/// while the interpreter is released.
inline std::shared_ptr<Execution> execution_or_new(const std::shared_ptr<Execution>& execution) {
    return execution ? execution : std::make_shared<Execution>();
}

}  // namespace meanvalue::bindings
