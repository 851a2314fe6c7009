#include "meanvalue/mesh/ring_mesh.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

RingMesh ring_mesh_of(const Mesh& mesh) {
    return {rings_of(mesh), Execution()};
}

/// Merges every vertex below `count` into the first neighbour that it may be merged into, whatever the cost, after
/// visit(its ring). @return how many were.
template <typename Visit>
int collapse_all(RingMesh& mesh, Index count, const Visit& visit) {
    int collapsed = 0;
    for (Index v = 0; v < count; ++v) {
        const RingView ring = mesh.ring(v);
        const Index* to = std::find_if(ring.begin(), ring.end(), [&](Index j) { return mesh.can_collapse(v, j); });
        if (to == ring.end()) continue;
        visit(ring);
        mesh.collapse(v, *to);
        ++collapsed;
    }
    return collapsed;
}

/// Every triangle, once for each corner that knows it, turned so that the lowest vertex comes first.
std::map<std::array<Index, 3>, int> triangles_of(const RingMesh& mesh) {
    std::map<std::array<Index, 3>, int> triangles;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const RingView ring = mesh.ring(v);
        for (Index k = 0; k < ring.triangle_count(); ++k) {
            std::array<Index, 3> corners = {v, ring.vertices[k], ring.vertices[(k + 1) % ring.valence]};
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
            ++triangles[corners];
        }
    }
    return triangles;
}

/// Vertices less edges plus triangles.
Index euler_number(const RingMesh& mesh, const std::map<std::array<Index, 3>, int>& triangles) {
    std::set<std::pair<Index, Index>> edges;
    std::set<Index> vertices;
    for (const auto& [corners, count] : triangles) {
        for (int k = 0; k < 3; ++k) {
            edges.insert(std::minmax(corners[k], corners[(k + 1) % 3]));
            vertices.insert(corners[k]);
        }
    }
    EXPECT_LE(static_cast<Index>(vertices.size()), mesh.vertex_count());
    return static_cast<Index>(vertices.size()) - static_cast<Index>(edges.size()) +
           static_cast<Index>(triangles.size());
}

class EveryRingMesh : public testing::TestWithParam<Mesh> {};

TEST_P(EveryRingMesh, CollapsesKeepAManifoldOfTheSameTopology) {
    RingMesh mesh = ring_mesh_of(GetParam());
    const Index euler = euler_number(mesh, triangles_of(mesh));
    int collapsed = 0;
    for (int round = 0; round < 20; ++round) {
        collapsed += collapse_all(mesh, mesh.vertex_count(), [](const RingView&) {});
        const auto triangles = triangles_of(mesh);
        for (const auto& [corners, count] : triangles)
            ASSERT_EQ(count, 3) << corners[0] << ' ' << corners[1] << ' ' << corners[2];
        ASSERT_EQ(euler_number(mesh, triangles), euler);
        std::map<std::pair<Index, Index>, int> half_edges;
        for (const auto& [corners, count] : triangles) {
            for (int k = 0; k < 3; ++k)
                ASSERT_EQ(++half_edges[std::make_pair(corners[k], corners[(k + 1) % 3])], 1);
        }
    }
    EXPECT_GT(collapsed, mesh.vertex_count() / 2);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        EXPECT_LE(mesh.ring(v).valence, 16);
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryRingMesh,
                         testing::Values(sphere(3), grid(20, 18, 0.02), torus(20, 12), capped_tube(12, 20, 6.0),
                                         joined(sphere(2), grid(8, 8, 0.0))));

TEST(RingMesh, ATetrahedronStays) {
    Mesh mesh;
    mesh.vertices = Positions::Random(4, 3);
    mesh.faces.resize(4, 3);
    mesh.faces << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
    const RingMesh rings = ring_mesh_of(mesh);
    for (Index from = 0; from < 4; ++from) {
        for (Index to = 0; to < 4; ++to)
            EXPECT_FALSE(rings.can_collapse(from, to));
    }
}

TEST(RingMesh, ABoundaryVertexMovesAlongTheBoundaryOnly) {
    const RingMesh rings = ring_mesh_of(grid(5, 5, 0.0));
    EXPECT_TRUE(rings.can_collapse(2, 1));
    EXPECT_TRUE(rings.can_collapse(2, 3));
    EXPECT_FALSE(rings.can_collapse(2, 7));
    EXPECT_TRUE(rings.can_collapse(7, 2));
    EXPECT_FALSE(rings.can_collapse(7, 14));  // no neighbours
}

TEST(RingMesh, ARingLongerThanItsBoundMayOnlyShrink) {
    RingMesh rings = ring_mesh_of(capped_tube(40, 6, 3.0));
    const Index middle = 6 * 40;
    EXPECT_EQ(rings.ring(middle).valence, 40);
    for (int round = 0; round < 10; ++round)
        collapse_all(rings, middle, [&](const RingView&) { EXPECT_LE(rings.ring(middle).valence, 40); });
}

TEST(RingMesh, OnlyShortRingsCanBeRemoved) {
    // What the coarsening does not look at: closed and open rings, at their longest.
    for (const Index valence : {16, 17, 18, 19, 25}) {
        const Mesh closed = capped_tube(valence, 4, 2.0);
        Mesh open = closed;  // without one triangle, at the middle of a cap and at its rim
        open.faces.conservativeResize(open.faces.rows() - 1, 3);
        for (const Mesh& mesh : {closed, open}) {
            RingMesh rings = ring_mesh_of(mesh);
            for (int round = 0; round < 10; ++round) {
                collapse_all(rings, mesh.vertex_count(),
                             [](const RingView& ring) { EXPECT_LE(ring.valence, RingMesh::kLongestRemovable); });
            }
        }
    }
}

TEST(RingMesh, NonManifoldVerticesStay) {
    Mesh mesh;
    mesh.vertices = Positions::Random(7, 3);
    mesh.faces.resize(3, 3);
    mesh.faces << 0, 1, 2, 0, 2, 3, 0, 5, 6;
    const RingMesh rings = ring_mesh_of(mesh);
    EXPECT_FALSE(rings.is_manifold(0));
    for (Index v = 1; v < 7; ++v) {
        EXPECT_FALSE(rings.can_collapse(0, v));
        EXPECT_FALSE(rings.can_collapse(v, 0));
    }
}

}  // namespace
}  // namespace meanvalue::tests
