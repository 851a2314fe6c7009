#include "meanvalue/mesh/one_ring.h"

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <mutex>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

struct Traits : OpenMesh::DefaultTraits {
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using HalfEdgeMesh = OpenMesh::PolyMesh_ArrayKernelT<Traits>;
using VertexHandle = HalfEdgeMesh::VertexHandle;
using HalfedgeHandle = HalfEdgeMesh::HalfedgeHandle;
using Corners = std::vector<VertexHandle>;

// OpenMesh goes around a vertex to find an edge, which is quadratic in its triangles. With more of them than this, a
// vertex is a hub: each of its edges ends in a vertex of its own, so that its triangles are quadrangles around a
// hole.
constexpr Index kMostAround = 256;

/// A run of triangles around a vertex that hang together by their edges.
struct Fan {
    std::vector<Index> ring;  // neighbors, counter-clockwise seen from outside
    bool closed = false;      // the triangles go all the way round
};

/// A triangle's other corners, counter-clockwise from the hub.
using Step = std::pair<Index, Index>;

/// Steps that hang together, in the order that OpenMesh has: open fans begin at their border, closed ones behind the
/// edge that the last triangle begins with.
void collect_fans_of_hub(const std::vector<Step>& steps, std::vector<Fan>& fans) {
    std::unordered_map<Index, Index> next(steps.begin(), steps.end());
    std::unordered_set<Index> has_before;
    for (const Step& step : steps)
        has_before.insert(step.second);
    const auto walk = [&](Index from, bool closed) {
        Fan fan;
        fan.closed = closed;
        if (!closed) fan.ring.push_back(from);
        for (auto step = next.find(from); step != next.end(); step = next.find(from)) {
            from = step->second;
            next.erase(step);
            fan.ring.push_back(from);
        }
        fans.push_back(std::move(fan));
    };
    for (const Step& step : steps) {
        if (has_before.count(step.first) == 0) walk(step.first, false);
    }
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
        if (next.count(step->first) != 0) walk(step->first, true);
    }
}

/// Which vertices are neighbors, and in which order.
struct Connectivity {
    HalfEdgeMesh mesh;
    std::vector<Index> original;  // per OpenMesh vertex: the caller's number; copies come after the originals
    std::unordered_map<Index, std::vector<VertexHandle>> copies;  // of the corners of detached triangles
    struct Hub {
        std::unordered_map<Index, VertexHandle> ends;  // of its edges, by their other end
        std::vector<Step> steps;
    };
    std::unordered_map<Index, Hub> hubs;

    VertexHandle add_vertex(Index vertex) {
        original.push_back(vertex);
        return mesh.add_vertex({});
    }

    void find_hubs(const TrianglesView& faces) {
        std::vector<Index> counts(original.size(), 0);
        for (Index f = 0; f < faces.rows(); ++f) {
            for (int k = 0; k < 3; ++k) {
                if (++counts[faces(f, k)] == kMostAround + 1) hubs.emplace(faces(f, k), Hub());
            }
        }
    }

    /// Of a triangle, with two in place of a hub.
    void find_corners(const TrianglesView& faces, Index f, Corners& corners) {
        corners.clear();
        for (int k = 0; k < 3; ++k) {
            const auto hub = hubs.empty() ? hubs.end() : hubs.find(faces(f, k));
            if (hub == hubs.end()) {
                corners.push_back(mesh.vertex_handle(faces(f, k)));
                continue;
            }
            for (const int other : {(k + 2) % 3, (k + 1) % 3}) {
                VertexHandle& end = hub->second.ends[faces(f, other)];
                if (!end.is_valid()) end = add_vertex(hub->first);
                corners.push_back(end);
            }
        }
    }

    /// Whether OpenMesh can take the triangle as it is: every corner must be open, every edge free on this side.
    bool fits(const Corners& corners) const {
        for (std::size_t k = 0; k < corners.size(); ++k) {
            if (!mesh.is_boundary(corners[k])) return false;
            const HalfedgeHandle edge = mesh.find_halfedge(corners[k], corners[(k + 1) % corners.size()]);
            if (edge.is_valid() && !mesh.is_boundary(edge)) return false;
        }
        return true;
    }

    bool add_face(const TrianglesView& faces, Index f, const Corners& corners) {
        if (!fits(corners) || !mesh.add_face(corners).is_valid()) return false;
        for (int k = 0; k < 3 && !hubs.empty(); ++k) {
            const auto hub = hubs.find(faces(f, k));
            if (hub != hubs.end()) hub->second.steps.emplace_back(faces(f, (k + 1) % 3), faces(f, (k + 2) % 3));
        }
        return true;
    }

    void add_fans(VertexHandle vertex, std::vector<Fan>& fans) const {
        // An open vertex's own half-edge has the hole on its left, so it ends a fan counter-clockwise.
        const HalfedgeHandle last = mesh.halfedge_handle(vertex);
        if (!last.is_valid()) return;
        const bool closed = !mesh.is_boundary(last);
        HalfedgeHandle edge = last;
        Fan fan;
        do {
            edge = mesh.ccw_rotated_halfedge_handle(edge);
            fan.ring.push_back(original[mesh.to_vertex_handle(edge).idx()]);
            if (mesh.is_boundary(edge)) {
                fans.push_back(std::move(fan));
                fan = Fan{};
            }
        } while (edge != last);
        if (closed) {
            fan.closed = true;
            fans.push_back(std::move(fan));
        }
    }

    /// All vertices and triangles. A triangle that does not fit is a loose piece with copies of its corners.
    /// @return how many do not fit.
    Index add(Index vertex_count, const TrianglesView& faces, const Execution& execution) {
        // OpenMesh would print to the console for each triangle that it refuses; we count and report instead. Its
        // switch is one for the process, so it is thrown once and for all.
        static std::once_flag silenced;
        std::call_once(silenced, [] { omerr().disable(); });
        mesh.reserve(vertex_count, faces.rows() * 3 / 2 + vertex_count, faces.rows());
        original.reserve(vertex_count);
        for (Index v = 0; v < vertex_count; ++v) {
            execution.check_every(v);
            add_vertex(v);
        }
        find_hubs(faces);
        Corners corners;
        std::vector<Index> detached;
        for (Index f = 0; f < faces.rows(); ++f) {
            execution.check_every(f);
            find_corners(faces, f, corners);
            if (!add_face(faces, f, corners)) detached.push_back(f);
        }
        for (const Index f : detached) {
            find_corners(faces, f, corners);
            if (std::none_of(corners.begin(), corners.end(), [&](auto v) { return mesh.is_boundary(v); })) continue;
            corners.clear();
            for (const Index v : faces.row(f)) {
                corners.push_back(add_vertex(v));
                copies[v].push_back(corners.back());
            }
            mesh.add_face(corners);
        }
        return static_cast<Index>(detached.size());
    }

    /// Every fan of triangles at `vertex`; none for a loose one. An inner vertex of a manifold has one closed fan, a
    /// boundary vertex one open fan.
    void collect_fans(Index vertex, std::vector<Fan>& fans) const {
        fans.clear();
        add_fans(mesh.vertex_handle(vertex), fans);
        const auto hub = hubs.find(vertex);
        if (hub != hubs.end()) collect_fans_of_hub(hub->second.steps, fans);
        const auto found = copies.find(vertex);
        if (found == copies.end()) return;
        for (const VertexHandle copy : found->second)
            add_fans(copy, fans);
    }
};

}  // namespace

void require_triangles(Index vertex_count, const TrianglesView& faces) {
    for (Index f = 0; f < faces.rows(); ++f) {
        for (int k = 0; k < 3; ++k) {
            if (faces(f, k) < 0 || faces(f, k) >= vertex_count) {
                throw InvalidInput(message("triangle ", f, " names vertex ", faces(f, k), ", but the mesh has ",
                                           vertex_count, " vertices, numbered from 0"));
            }
        }
        if (faces(f, 0) == faces(f, 1) || faces(f, 1) == faces(f, 2) || faces(f, 2) == faces(f, 0)) {
            throw InvalidInput(message("triangle ", f, " names a vertex twice (", faces(f, 0), ", ", faces(f, 1),
                                       ", ", faces(f, 2), "); remove it"));
        }
    }
}

void require_mesh(const Positions& vertices, const Triangles& faces, const char* vertices_name,
                  const char* faces_name) {
    require_finite(vertices, vertices_name);
    require_moderate_extent(vertices);
    try {
        require_triangles(static_cast<Index>(vertices.rows()), faces);
    } catch (const InvalidInput& error) {
        throw InvalidInput(message(faces_name, ": ", error.what()));
    }
}

void OneRings::reserve(Index vertex_count) {
    offsets.reserve(vertex_count + 1);
    kinds.reserve(vertex_count);
    closed.reserve(vertex_count);
    vertices.reserve(std::size_t{6} * vertex_count);
}

void OneRings::append(const Index* begin, const Index* end, RingKind kind, bool is_closed) {
    kinds.push_back(kind);
    closed.push_back(is_closed ? 1 : 0);
    vertices.insert(vertices.end(), begin, end);
    offsets.push_back(static_cast<Index>(vertices.size()));
}

OneRings collect_one_rings(Index vertex_count, const TrianglesView& faces, const Execution& execution) {
    require_triangles(vertex_count, faces);
    Connectivity mesh;
    OneRings rings;
    rings.detached_triangle_count = mesh.add(vertex_count, faces, execution);
    rings.reserve(vertex_count);
    std::vector<Fan> fans;
    for (Index v = 0; v < vertex_count; ++v) {
        execution.check_every(v);
        mesh.collect_fans(v, fans);
        if (fans.empty()) {
            rings.append(nullptr, nullptr, RingKind::kLoose, false);
            continue;
        }
        const auto largest = std::max_element(
            fans.begin(), fans.end(), [](const Fan& a, const Fan& b) { return a.ring.size() < b.ring.size(); });
        const RingKind kind = fans.size() > 1       ? RingKind::kNonManifold
                              : fans.front().closed ? RingKind::kClosed
                                                    : RingKind::kOpen;
        rings.append(largest->ring.data(), largest->ring.data() + largest->ring.size(), kind, largest->closed);
    }
    return rings;
}

}  // namespace meanvalue
