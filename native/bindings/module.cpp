#include "bindings/bind.h"

PYBIND11_MODULE(meanvalue, module) {
    module.doc() =
        "Mean-value geometry encoding (Kraevoy and Sheffer): a rotation-invariant description of each vertex by "
        "its neighbours, from which a mesh is rebuilt when a few anchor vertices move.";
    module.attr("__version__") = MEANVALUE_VERSION;
    meanvalue::bindings::bind_execution(module);
    meanvalue::bindings::bind_encoding(module);
    meanvalue::bindings::bind_deformer(module);
    meanvalue::bindings::bind_baselines(module);
}
