#include "bindings/arrays.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>

#include "meanvalue/common/errors.h"

namespace meanvalue::bindings {
namespace {

using LongArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
    return py::str(array.attr("shape"));
}

std::string type_text(const py::array& array) {
    return py::str(array.dtype());
}

/// One of numpy's letters for kinds of types: what a cast may do to the others is silent, and never what was meant.
bool is_of_kind(const py::array& array, const char* kinds) {
    return std::string(kinds).find(array.dtype().kind()) != std::string::npos;
}

/// @param wanted what to give instead, for the message.
py::array as_array(const py::object& values, const char* name, const char* wanted) {
    if (py::hasattr(values, "mask") && py::hasattr(values, "filled")) {
        throw InvalidInput(message(name,
                                   " is a masked array, of which the masked values would be taken as well; give ",
                                   wanted, ", by filled() or compressed()"));
    }
    py::array array = array_or_nothing(values);
    if (!array) throw InvalidInput(message(name, " cannot be made an array; give ", wanted));
    return array;
}

/// Whole numbers, or nothing at all: numpy makes an empty list one of float64. @param of what they number.
/// @param of_flags how they are had of flags, where they could be meant.
IndexArray as_integers(const py::array& array, const char* name, const char* of, const char* of_flags = "") {
    if (!is_of_kind(array, "iu") && !(array.size() == 0 && is_of_kind(array, "f"))) {
        throw InvalidInput(message(name, " has the type ", type_text(array), "; give whole numbers (int32)",
                                   is_of_kind(array, "b") ? of_flags : ""));
    }
    const auto refuse = [&](auto number) {
        throw InvalidInput(message(name, " holds ", number, ", which no number of a ", of, " can be"));
    };
    if (is_of_kind(array, "u")) {  // of 64 bits, those above 2^63 would become negative
        const py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast> numbers(array);
        const std::uint64_t most = std::numeric_limits<Index>::max();
        for (py::ssize_t k = 0; k < numbers.size(); ++k) {
            if (numbers.data()[k] > most) refuse(numbers.data()[k]);
        }
    }
    if (array.itemsize() <= static_cast<py::ssize_t>(sizeof(Index)) && is_of_kind(array, "i"))
        return IndexArray(array);
    const LongArray integers(array);
    const std::int64_t* item = integers.data();
    for (py::ssize_t k = 0; k < integers.size(); ++k) {
        if (item[k] < std::numeric_limits<Index>::min() || item[k] > std::numeric_limits<Index>::max()) {
            refuse(item[k]);
        }
    }
    return IndexArray(array);
}

}  // namespace

py::array array_or_nothing(const py::handle& values) {
    try {
        return py::array(py::reinterpret_borrow<py::object>(values));
    } catch (const py::error_already_set& error) {
        if (!error.matches(PyExc_Exception)) throw;
        return py::reinterpret_steal<py::array>(py::handle());
    }
}

PositionsArray::PositionsArray(const py::object& values, const char* name) {
    constexpr const char* kWanted = "(n, 3) of float64";
    const py::array array = as_array(values, name, kWanted);
    if (array.ndim() != 2 || array.shape(1) != 3) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), "; give (n, 3)"));
    }
    if (!is_of_kind(array, "fiu")) {
        throw InvalidInput(message(name, " has the type ", type_text(array), "; give ", kWanted));
    }
    array_ = FloatArray(array);
}

Positions own_positions(const py::object& values, const char* name) {
    using Singles = py::array_t<float, py::array::c_style>;
    const py::array array = as_array(values, name, "(n, 3) of float64");
    if (!Singles::check_(array) || array.ndim() != 2 || array.shape(1) != 3)
        return PositionsArray(array, name).view();
    using Rows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    return Eigen::Map<const Rows>(Singles(array).data(), array.shape(0), 3).cast<double>();
}

IndexArray as_edges(const py::object& values, const char* name) {
    const py::array array = array_or_nothing(values);
    if (!array || array.ndim() != 2 || array.shape(1) != 2)
        throw InvalidInput(message(name, " are no array of the shape (m, 2); give the two vertices of each"));
    return as_integers(array, name, "vertex");
}

Triangles as_triangles(const py::object& values, const char* name) {
    const py::array array = as_array(values, name, "(m, 3) of int32");
    if (array.ndim() != 2 || array.shape(1) != 3) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array),
                                   "; give (m, 3) triangles, which triangulate() makes of polygons"));
    }
    const IndexArray integers = as_integers(array, name, "vertex");
    return Eigen::Map<const Triangles>(integers.data(), integers.shape(0), 3);
}

std::optional<Polygons> as_polygons(const py::object& faces) {
    const auto is_list_of_numbers = [](const py::handle& item) {
        return py::isinstance<py::array>(item) && py::reinterpret_borrow<py::array>(item).ndim() == 1;
    };
    Polygons result;
    if (py::isinstance<py::tuple>(faces) && py::len(faces) == 2) {
        const auto pair = py::reinterpret_borrow<py::tuple>(faces);
        const bool are_triangles = py::len(pair[0]) == 3 && py::len(pair[1]) == 3;
        if (is_list_of_numbers(pair[0]) && is_list_of_numbers(pair[1]) && !are_triangles) {
            result.offsets = as_indices(pair[0], "faces[0]", "corner");
            result.corners = as_indices(pair[1], "faces[1]", "vertex");
            return result;
        }
    }
    const py::array array = array_or_nothing(faces);
    result.offsets.push_back(0);
    if (array && array.ndim() == 2 && array.shape(1) > 3) {
        const IndexArray integers = as_integers(array, "faces", "vertex");
        result.corners.assign(integers.data(), integers.data() + integers.size());
        for (py::ssize_t face = 1; face <= array.shape(0); ++face)
            result.offsets.push_back(static_cast<Index>(face * array.shape(1)));
        return result;
    }
    if (!py::isinstance<py::sequence>(faces) || (array && (array.ndim() != 1 || !is_of_kind(array, "O")))) {
        return {};
    }
    for (const py::handle face : py::iter(faces)) {
        const py::array corners = array_or_nothing(face);
        if (!corners || corners.ndim() != 1) return {};
        const std::string name = message("faces[", result.offsets.size() - 1, "]");
        const std::vector<Index> owned = as_indices(corners, name.c_str(), "vertex");
        result.corners.insert(result.corners.end(), owned.begin(), owned.end());
        result.offsets.push_back(static_cast<Index>(result.corners.size()));
    }
    return result;
}

Triangles triangles_of(const py::object& faces, const Positions& vertices, const char* name) {
    const std::optional<Polygons> polygons = as_polygons(faces);
    return polygons ? triangulate(vertices, *polygons).triangles : as_triangles(faces, name);
}

std::vector<Index> as_indices(const py::object& values, const char* name, const char* of) {
    const py::array array = as_array(values, name, "(k,) of int32");
    if (array.ndim() != 1) {  // a column is what libigl's scripts make
        throw InvalidInput(message(name, " has the shape ", shape_text(array), "; give (k,)",
                                   array.ndim() == 2 && array.shape(1) == 1 ? ", by numpy.ravel()" : ""));
    }
    const bool are_vertices = std::string_view(of) == "vertex";
    const IndexArray integers = as_integers(array, name, of, are_vertices ? ", of flags by numpy.flatnonzero()" : "");
    return {integers.data(), integers.data() + integers.size()};
}

std::vector<double> as_numbers(const py::object& values, const char* name) {
    const FloatArray numbers = as_floats(values, name, 1, "(k,) of float");
    return {numbers.data(), numbers.data() + numbers.size()};
}

FloatArray as_floats(const py::object& values, const char* name, int dimensions, const char* wanted) {
    const py::array array = as_array(values, name, wanted);
    if (array.ndim() != dimensions || !is_of_kind(array, "fiu")) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), " and the type ", type_text(array),
                                   "; give ", wanted));
    }
    return FloatArray(array);
}

std::optional<std::vector<char>> as_flags(const std::optional<py::object>& values, const char* name) {
    if (!values) return std::nullopt;
    constexpr const char* kWanted = "(n,) of bool";
    const py::array array = as_array(*values, name, kWanted);
    if (array.ndim() != 1 || !is_of_kind(array, "b")) {
        throw InvalidInput(message(name, " has the shape ", shape_text(array), " and the type ", type_text(array),
                                   "; give ", kWanted));
    }
    const py::array_t<bool, py::array::c_style | py::array::forcecast> flags(array);
    // By bytes: a view of other numbers may hold more than 0 and 1, which no bool of C++ may.
    const auto* const bytes = static_cast<const unsigned char*>(static_cast<const py::array&>(flags).data());
    std::vector<char> result;
    std::transform(bytes, bytes + flags.size(), std::back_inserter(result), [](auto byte) { return byte != 0; });
    return result;
}

py::array_t<double> to_array(Positions&& positions) {
    auto* owned = new Positions(std::move(positions));
    const py::capsule owner(owned, [](void* pointer) { delete static_cast<Positions*>(pointer); });
    return py::array_t<double>({static_cast<py::ssize_t>(owned->rows()), py::ssize_t{3}}, owned->data(), owner);
}

std::vector<SharedPositions> own_shapes(const py::object& shapes, const char* name) {
    if (!py::isinstance<py::sequence>(shapes) && !py::isinstance<py::array>(shapes)) {
        throw ::meanvalue::InvalidInput(
            message(name, " is no sequence; give (k, n, 3), or one (n, 3) for each shape"));
    }
    std::vector<SharedPositions> result;
    for (const py::handle shape : py::iter(shapes)) {
        const std::string name_of_shape = message(name, "[", result.size(), "]");
        result.push_back(
            share(PositionsArray(py::reinterpret_borrow<py::object>(shape), name_of_shape.c_str()).view(),
                  name_of_shape.c_str()));
    }
    return result;
}

}  // namespace meanvalue::bindings
