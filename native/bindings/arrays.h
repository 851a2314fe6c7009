// Conversion between numpy arrays and the core's types, and nothing else.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <vector>

#include "bindings/polygons.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"

namespace meanvalue::bindings {

namespace py = pybind11;

/// float64, C-order; other number types are converted, which copies.
using FloatArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Nothing where numpy makes no array of it. Ctrl-C meanwhile is Ctrl-C, which py::array::ensure() would swallow.
py::array array_or_nothing(const py::handle& values);

using IndexArray = py::array_t<Index, py::array::c_style | py::array::forcecast>;

/// Positions that came from Python, from an array or anything that numpy makes one of: float64 in C-order is seen
/// without a copy, other real numbers are converted.
class PositionsArray {
  public:
    /// @throws InvalidInput where they are not (n, 3), or not real numbers, naming the argument.
    PositionsArray(const py::object& values, const char* name);

    Eigen::Map<const Positions> view() const { return {array_.data(), array_.shape(0), 3}; }

  private:
    FloatArray array_;
};

/// As PositionsArray, for who keeps them: single precision is converted in one step.
Positions own_positions(const py::object& values, const char* name);

/// Positions of several shapes, from an array (k, n, 3) or a sequence of arrays. @throws InvalidInput as
/// PositionsArray.
std::vector<SharedPositions> own_shapes(const py::object& shapes, const char* name);

/// From an array or anything that numpy makes one of. @throws InvalidInput where they are not (m, 3), not of an
/// integer type, or out of the 32-bit range.
Triangles as_triangles(const py::object& values, const char* name);

/// Pairs of vertices, (m, 2), seen without a copy where they are int32 in C-order. @throws InvalidInput where they
/// are not that, not of an integer type, or out of the 32-bit range.
IndexArray as_edges(const py::object& values, const char* name);

/// Faces of any number of corners: (m, k), a sequence of (k,) of different lengths, or a tuple of two arrays, offsets
/// and corners as of Polygons. None where they are something else, as (m, 3). @throws InvalidInput where they are not
/// of an integer type, or out of the 32-bit range.
std::optional<Polygons> as_polygons(const py::object& faces);

/// Of either kind of faces. @throws InvalidInput as both, and as triangulate().
Triangles triangles_of(const py::object& faces, const Positions& vertices, const char* name = "faces");

/// From an array or anything that numpy makes one of. @param of what they number, for the message.
/// @throws InvalidInput where they are not (k,), not of an integer type, or out of the 32-bit range.
std::vector<Index> as_indices(const py::object& values, const char* name, const char* of);

/// From an array or anything that numpy makes one of. @throws InvalidInput where they are not (k,), or not real
/// numbers.
std::vector<double> as_numbers(const py::object& values, const char* name);

/// @param dimensions how many there are to be. @param wanted what to give instead, for the message.
/// @throws InvalidInput where there are others, or no real numbers, naming the argument.
FloatArray as_floats(const py::object& values, const char* name, int dimensions, const char* wanted);

/// From an array or anything that numpy makes one of. @throws InvalidInput where they are not (n,) of bool.
std::optional<std::vector<char>> as_flags(const std::optional<py::object>& values, const char* name);

/// Moves positions into a new (n, 3) array without a copy.
py::array_t<double> to_array(Positions&& positions);

/// A read-only (n,) array that looks at `items`, kept alive by `owner`.
template <typename T>
py::array_t<T> view_of(const std::vector<T>& items, const py::object& owner) {
    py::array_t<T> array(static_cast<py::ssize_t>(items.size()), items.data(), owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

}  // namespace meanvalue::bindings
