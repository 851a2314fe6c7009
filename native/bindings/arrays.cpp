#include "bindings/arrays.h"

#include <limits>

#include "meanvalue/common/errors.h"

namespace meanvalue::bindings {
namespace {

using LongArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
    return py::str(array.attr("shape"));
}

py::array as_array(const py::object& values, const char* name) {
    py::array array = py::array::ensure(values);
    if (!array) throw InvalidInput(message(name, " cannot be made an array of numbers"));
    return array;
}

/// Checks the type and the range; float indices would be cut off silently by a plain cast.
LongArray as_integers(const py::array& array, const char* name) {
    const char kind = array.dtype().kind();
    if (array.size() > 0 && kind != 'i' && kind != 'u') {
        throw InvalidInput(
            message(name, " has the type ", std::string(py::str(array.dtype())), "; give whole numbers (int32)"));
    }
    LongArray integers(array);
    const std::int64_t* item = integers.data();
    for (py::ssize_t k = 0; k < integers.size(); ++k) {
        if (item[k] < std::numeric_limits<Index>::min() || item[k] > std::numeric_limits<Index>::max()) {
            throw InvalidInput(message(name, " holds ", item[k], ", which no vertex number can be"));
        }
    }
    return integers;
}

}  // namespace

Eigen::Map<const Positions> as_positions(const FloatArray& array, const char* name) {
    if (array.ndim() != 2 || array.shape(1) != 3) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), "; give (n, 3)"));
    }
    return {array.data(), array.shape(0), 3};
}

Triangles as_triangles(const py::object& values, const char* name) {
    const py::array array = as_array(values, name);
    if (array.ndim() != 2 || array.shape(1) != 3) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array),
                                   "; give (m, 3): split polygons into triangles first"));
    }
    const LongArray integers = as_integers(array, name);
    using LongTriangles = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
    return Eigen::Map<const LongTriangles>(integers.data(), integers.shape(0), 3).cast<Index>();
}

std::vector<Index> as_indices(const py::object& values, const char* name) {
    const py::array array = as_array(values, name);
    if (array.ndim() != 1) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), "; give (k,)"));
    }
    const LongArray integers = as_integers(array, name);
    return {integers.data(), integers.data() + integers.size()};
}

std::vector<double> as_numbers(const py::object& values, const char* name) {
    const py::array array = as_array(values, name);
    const char kind = array.dtype().kind();
    if (array.ndim() != 1 || (kind != 'f' && kind != 'i' && kind != 'u')) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), " and the type ",
                                   std::string(py::str(array.dtype())), "; give (k,) of float"));
    }
    const FloatArray numbers(array);
    return {numbers.data(), numbers.data() + numbers.size()};
}

std::optional<std::vector<char>> as_flags(const std::optional<py::object>& values, const char* name) {
    if (!values) return std::nullopt;
    const py::array array = as_array(*values, name);
    if (array.ndim() != 1 || array.dtype().kind() != 'b') {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), " and the type ",
                                   std::string(py::str(array.dtype())), "; give (n,) of bool"));
    }
    const py::array_t<bool, py::array::c_style | py::array::forcecast> flags(array);
    return std::vector<char>(flags.data(), flags.data() + flags.size());
}

py::array_t<double> to_array(Positions&& positions) {
    auto* owned = new Positions(std::move(positions));
    const py::capsule owner(owned, [](void* pointer) { delete static_cast<Positions*>(pointer); });
    return py::array_t<double>({static_cast<py::ssize_t>(owned->rows()), py::ssize_t{3}}, owned->data(), owner);
}

}  // namespace meanvalue::bindings
