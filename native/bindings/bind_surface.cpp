#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/task.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/mesh/same_places.h"
#include "meanvalue/mesh/surface_ways.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue::bindings {
namespace {

std::shared_ptr<SurfaceWays> make_ways(const py::object& vertices, const py::object& edges, const py::object& faces,
                                       double gap, int threads) {
    Positions positions = own_positions(vertices, "vertices");
    const IndexArray ends = as_edges(edges, "edges");
    const Eigen::Map<const SurfaceWays::Edges> pairs(ends.data(), ends.shape(0), 2);
    const Triangles triangles = as_triangles(faces, "faces");
    const auto execution = std::make_shared<Execution>();
    return beside(execution, [&] {
        return std::make_shared<SurfaceWays>(std::move(positions), pairs, triangles, gap, thread_count(threads),
                                             *execution);
    });
}

template <typename Find>
py::array_t<double> without_python(const py::object& seeds, const Find& find) {
    const std::vector<Index> owned = as_indices(seeds, "seeds", "vertex");
    const std::vector<double> found = beside(std::make_shared<Execution>(), [&] { return find(owned); });
    return py::array_t<double>(static_cast<py::ssize_t>(found.size()), found.data());
}

py::array_t<double> distances_of(const SurfaceWays& ways, const py::object& seeds, double limit) {
    return without_python(seeds, [&](const std::vector<Index>& owned) { return ways.distances(owned, limit); });
}

py::array_t<double> falloff_of(const SurfaceWays& ways, const py::object& seeds, double limit, double free) {
    return without_python(seeds, [&](const std::vector<Index>& owned) { return ways.falloff(owned, limit, free); });
}

double limb_of(const SurfaceWays& ways, Index vertex, double least, double limit) {
    return beside(std::make_shared<Execution>(), [&] { return ways.limb(vertex, least, limit); });
}

/// Triangles that were given, and the tree that looks at them.
struct Surface {
    Surface(Positions given, Triangles triangles, const Execution& execution)
        : vertices(std::move(given)),
          part_of(static_cast<std::size_t>(vertices.rows()), 0),
          tree(vertices, std::move(triangles), part_of, execution) {}

    Positions vertices;
    std::vector<Index> part_of;
    TriangleTree tree;
};

std::unique_ptr<Surface> make_surface(const py::object& vertices, const py::object& faces) {
    Positions positions = PositionsArray(vertices, "vertices").view();
    Triangles triangles = as_triangles(faces, "faces");
    const auto execution = std::make_shared<Execution>();
    return beside(execution,
                  [&] { return std::make_unique<Surface>(std::move(positions), std::move(triangles), *execution); });
}

py::tuple nearest_places(const Surface& surface, const py::object& points, const std::optional<py::object>& normals,
                         double least_cosine, int threads) {
    const PositionsArray given(points, "points");
    const std::optional<PositionsArray> turned =
        normals ? std::optional<PositionsArray>(std::in_place, *normals, "normals") : std::nullopt;
    const auto places = given.view();
    if (turned && turned->view().rows() != places.rows()) {
        throw ::meanvalue::InvalidInput(message("there are ", places.rows(), " points and ", turned->view().rows(),
                                                " normals; give one for each"));
    }
    const auto count = static_cast<Index>(places.rows());
    py::array_t<Index> found(count);
    py::array_t<double> distances(count);
    Positions weights = Positions::Zero(count, 3);
    Index* const triangle = found.mutable_data();
    double* const distance = distances.mutable_data();
    const auto execution = std::make_shared<Execution>();
    beside(execution, [&] {
        parallel_for(count, thread_count(threads), *execution, [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k) {
                TriangleTree::Query query;
                query.point = places.row(k);
                const Vector3 normal = turned ? Vector3(turned->view().row(k)) : Vector3();
                if (turned) query.normal = &normal;
                query.least_cosine = least_cosine;
                const TriangleTree::Place place = surface.tree.nearest(query, std::numeric_limits<double>::max());
                triangle[k] = place.triangle;
                distance[k] = std::numeric_limits<double>::infinity();
                if (place.triangle < 0) continue;
                weights.row(k) = place.weights;
                distance[k] = (place.point - query.point).norm();
            }
        });
        return true;
    });
    return py::make_tuple(found, to_array(std::move(weights)), distances);
}

py::array_t<Index> firsts_of_places(const py::object& points, double distance) {
    const PositionsArray given(points, "points");
    const auto execution = std::make_shared<Execution>();
    const std::vector<Index> found =
        beside(execution, [&] { return first_of_place(given.view(), distance, *execution); });
    return py::array_t<Index>(static_cast<py::ssize_t>(found.size()), found.data());
}

py::array_t<Index> firsts_of_seams(const py::object& points, const py::object& face_corners,
                                   const py::object& face_starts, double distance) {
    const PositionsArray given(points, "points");
    const std::vector<Index> corners = as_indices(face_corners, "face_corners", "vertex");
    const std::vector<Index> starts = as_indices(face_starts, "face_starts", "corner");
    const auto execution = std::make_shared<Execution>();
    const std::vector<Index> found =
        beside(execution, [&] { return first_of_seams(given.view(), corners, starts, distance, *execution); });
    return py::array_t<Index>(static_cast<py::ssize_t>(found.size()), found.data());
}

py::array_t<Index> borders(Index count, const py::object& face_corners, const py::object& face_starts) {
    const std::vector<Index> corners = as_indices(face_corners, "face_corners", "vertex");
    const std::vector<Index> starts = as_indices(face_starts, "face_starts", "corner");
    const auto execution = std::make_shared<Execution>();
    const auto found = beside(execution, [&] { return border_edges(count, corners, starts, *execution); });
    py::array_t<Index> edges({static_cast<py::ssize_t>(found.size()), py::ssize_t{2}});
    for (std::size_t e = 0; e < found.size(); ++e) {
        edges.mutable_at(e, 0) = found[e].first;
        edges.mutable_at(e, 1) = found[e].second;
    }
    return edges;
}

}  // namespace

void bind_surface(py::module_& module) {
    py::class_<Surface>(module, "Surface", py::module_local(), "Triangles, to look up which is nearest to a point.")
        .def(py::init(&make_surface), py::arg("vertices"), py::arg("faces"),
             "vertices: (n, 3). faces: (t, 3) int32; those with a corner that is not finite are left out.\n"
             "Raises InvalidInput that names what is wrong.")
        .def("nearest", &nearest_places, py::arg("points"), py::arg("normals") = py::none(),
             py::arg("least_cosine") = 0.0, py::kw_only(), py::arg("threads") = 0,
             "(face (k,) int32, weights of its corners (k, 3), distance (k,)) nearest to points (k, 3); of equally "
             "near\n"
             "faces the first. normals: (k, 3), of unit length: only faces count whose own has a cosine above\n"
             "`least_cosine` with that of the point. Where there is none, face -1, weights 0, distance infinite.\n"
             "Raises InvalidInput that names what is wrong.");
    py::class_<SurfaceWays, std::shared_ptr<SurfaceWays>>(
        module, "SurfaceWays", py::module_local(),
        "How far it is over a surface from some vertices to others: along edges, and over to another piece where\n"
        "two touch or nearly touch. The gap between them counts as nothing, so that layers are equally far.")
        .def(py::init(&make_ways), py::arg("vertices"), py::arg("edges"), py::arg("faces"), py::kw_only(),
             py::arg("gap") = 0.0, py::arg("threads") = 0,
             "vertices: (n, 3). edges: (m, 2) int32. faces: (t, 3) int32, the surfaces of the pieces; none (0, 3):\n"
             "pieces stay apart. gap: pieces no farther apart than this nearly touch; where half the shortest edge\n"
             "at a vertex is longer, that counts.\n"
             "Raises InvalidInput that names what is wrong.")
        .def("distances", &distances_of, py::arg("seeds"), py::arg("limit"),
             "(n,) float64: about how far each vertex is from the nearest of the vertices `seeds`, infinite beyond\n"
             "`limit`, and -1 in pieces without a seed of which no vertex is beyond it.\n"
             "Raises InvalidInput.")
        .def("falloff", &falloff_of, py::arg("seeds"), py::arg("limit"), py::arg("free") = 0.0,
             "(n,) float64, 0 to 1: how much each vertex follows. 1 up to the share `free` of the limit, and in "
             "pieces\n"
             "that are completely within it, 0 from the limit on, or from two and a half edges on where that is "
             "more.\n"
             "Raises InvalidInput.")
        .def("limb", &limb_of, py::arg("vertex"), py::arg("least"), py::arg("limit"),
             "How far the limb goes that the vertex is on, up to the body, at least `least` and at most `limit`; 0\n"
             "where it is on none.\n"
             "Raises InvalidInput.")
        .def_property_readonly(
            "parts", [](const py::object& self) { return view_of(self.cast<const SurfaceWays&>().parts(), self); },
            "(n,) int32: the lowest vertex of the connected piece of each.");
    module.def(
        "triangulate",
        [](const py::object& vertices, const py::object& faces) {
            const PositionsArray positions(vertices, "vertices");
            std::optional<Polygons> polygons = as_polygons(faces);
            if (!polygons) {
                const Triangles triangles = as_triangles(faces, "faces");
                polygons = Polygons{{0}, {triangles.data(), triangles.data() + triangles.size()}};
                for (Index corner = 3; corner <= triangles.size(); corner += 3)
                    polygons->offsets.push_back(corner);
            }
            const auto result = std::make_unique<Triangulation>(triangulate(positions.view(), *polygons));
            return py::make_tuple(
                py::array_t<Index>({result->triangles.rows(), Eigen::Index{3}}, result->triangles.data()),
                py::array_t<Index>(static_cast<py::ssize_t>(result->polygons.size()), result->polygons.data()));
        },
        py::arg("vertices"), py::arg("faces"),
        "The triangles that Blender shows of polygons: (triangles (t, 3) int32, polygons (t,) int32, the face that\n"
        "each is a part of).\n\n"
        "vertices: (n, 3); faces: as of Deformer(). Raises InvalidInput that names what is wrong.");
    module.def(
        "border_edges", &borders, py::arg("vertex_count"), py::arg("face_corners"), py::arg("face_starts"),
        "(m, 2) int32: the edges that one face alone has, the lower vertex first, ascending. face_corners: (c,)\n"
        "int32, the vertices of faces one after another. face_starts: (f,) int32, where each begins in it.\n"
        "Raises InvalidInput that names what is wrong.");
    module.def(
        "first_of_place", &firsts_of_places, py::arg("points"), py::arg("distance"),
        "(n,) int32: for each of points (n, 3) the lowest of those that steps of at most `distance` lead to;\n"
        "itself for one that is not finite. Of more than 8 points that are nearer together than about half of\n"
        "that, those that are outermost along the axes stand for all in steps to others.\n"
        "Raises InvalidInput that names what is wrong.");
    module.def(
        "first_of_seams", &firsts_of_seams, py::arg("points"), py::arg("face_corners"), py::arg("face_starts"),
        py::arg("distance"),
        "(n,) int32: for each of points (n, 3) one that it is one with: vertices of open borders in one place are,\n"
        "and those of a double, a piece that lies on others with all its vertices and begins at such a border.\n"
        "Other vertices in one place are layers, and stay apart. It is the lowest, but no double's if it can be.\n"
        "Places are as of first_of_place(), faces as of border_edges().\n"
        "Raises InvalidInput that names what is wrong.");
}

}  // namespace meanvalue::bindings
