#include "meanvalue/mesh/triangle_mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <array>
#include <mutex>
#include <unordered_map>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

struct Traits : OpenMesh::DefaultTraits {
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using VertexHandle = HalfEdgeMesh::VertexHandle;
using HalfedgeHandle = HalfEdgeMesh::HalfedgeHandle;

}  // namespace

struct TriangleMesh::Connectivity {
    HalfEdgeMesh mesh;
    std::vector<Index> original;  // per OpenMesh vertex: the caller's number; copies come after the originals
    std::unordered_map<Index, std::vector<VertexHandle>> copies;  // of the corners of detached triangles

    VertexHandle add_copy(Index vertex) {
        const VertexHandle copy = mesh.add_vertex({});
        original.push_back(vertex);
        copies[vertex].push_back(copy);
        return copy;
    }

    /// Whether OpenMesh can take the triangle as it is: every corner must be open, every edge free on this side.
    bool fits(const std::array<VertexHandle, 3>& corners) const {
        for (int k = 0; k < 3; ++k) {
            if (!mesh.is_boundary(corners[k])) return false;
            const HalfedgeHandle edge = mesh.find_halfedge(corners[k], corners[(k + 1) % 3]);
            if (edge.is_valid() && !mesh.is_boundary(edge)) return false;
        }
        return true;
    }

    void collect_fans(VertexHandle vertex, std::vector<Fan>& fans) const {
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
};

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

TriangleMesh::TriangleMesh(Index vertex_count, const TrianglesView& faces, const Execution& execution)
    : vertex_count_(vertex_count), connectivity_(std::make_unique<Connectivity>()) {
    require_triangles(vertex_count, faces);
    add_faces(faces, execution);
}

TriangleMesh::~TriangleMesh() = default;
TriangleMesh::TriangleMesh(TriangleMesh&&) noexcept = default;
TriangleMesh& TriangleMesh::operator=(TriangleMesh&&) noexcept = default;

void TriangleMesh::add_faces(const TrianglesView& faces, const Execution& execution) {
    // OpenMesh would print to the console for each triangle that it refuses; we count and report instead. Its switch
    // is one for the process, so it is thrown once and for all.
    static std::once_flag silenced;
    std::call_once(silenced, [] { omerr().disable(); });
    HalfEdgeMesh& mesh = connectivity_->mesh;
    mesh.reserve(vertex_count_, faces.rows() * 3 / 2 + vertex_count_, faces.rows());
    connectivity_->original.resize(vertex_count_);
    for (Index v = 0; v < vertex_count_; ++v) {
        execution.check_every(v);
        mesh.add_vertex({});
        connectivity_->original[v] = v;
    }
    for (Index f = 0; f < faces.rows(); ++f) {
        execution.check_every(f);
        std::array<VertexHandle, 3> corners;
        for (int k = 0; k < 3; ++k)
            corners[k] = mesh.vertex_handle(faces(f, k));
        if (connectivity_->fits(corners) && mesh.add_face(corners[0], corners[1], corners[2]).is_valid()) continue;
        for (int k = 0; k < 3; ++k)
            corners[k] = connectivity_->add_copy(faces(f, k));
        mesh.add_face(corners[0], corners[1], corners[2]);
        ++detached_count_;
    }
}

void TriangleMesh::collect_fans(Index vertex, std::vector<Fan>& fans) const {
    fans.clear();
    connectivity_->collect_fans(connectivity_->mesh.vertex_handle(vertex), fans);
    const auto copies = connectivity_->copies.find(vertex);
    if (copies == connectivity_->copies.end()) return;
    for (const VertexHandle copy : copies->second)
        connectivity_->collect_fans(copy, fans);
}

}  // namespace meanvalue
