#include "meanvalue/mesh/one_ring.h"

#include <algorithm>
#include <ctime>
#include <numeric>
#include <random>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

std::vector<Index> rotated_to(std::vector<Index> ring, Index first) {
    std::rotate(ring.begin(), std::find(ring.begin(), ring.end(), first), ring.end());
    return ring;
}

std::vector<Index> ring(const OneRings& rings, Index vertex) {
    return {rings.begin(vertex), rings.end(vertex)};
}

TEST(OneRing, IsCounterClockwiseAndBeginsAndEndsAtABoundary) {
    const OneRings rings = rings_of(grid(3, 3, 0.0));
    EXPECT_EQ(rings.kinds[4], RingKind::kClosed);
    EXPECT_EQ(rotated_to(ring(rings, 4), 5), (std::vector<Index>{5, 8, 7, 3, 0, 1}));
    EXPECT_EQ(rings.kinds[1], RingKind::kOpen);
    EXPECT_EQ(ring(rings, 1), (std::vector<Index>{2, 5, 4, 0}));
}

TEST(OneRing, HasAnyValenceAndNoneForALooseVertex) {
    EXPECT_EQ(rings_of(capped_tube(160, 3, 1.0)).valence(3 * 160), 160);
    Mesh mesh = triangle();
    mesh.vertices.conservativeResize(4, 3);
    mesh.vertices.row(3) << 5, 5, 5;
    const OneRings rings = rings_of(mesh);
    EXPECT_EQ(rings.kinds[3], RingKind::kLoose);
    EXPECT_EQ(rings.valence(3), 0);
}

TEST(OneRing, OfAVertexWithAnyNumberOfTrianglesIsFoundInLinearTime) {
    constexpr Index kSpokes = 40000;
    std::vector<Index> order(kSpokes);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    Mesh mesh;
    mesh.vertices = Positions::Random(kSpokes + 1, 3);
    for (const bool closed : {true, false}) {
        mesh.faces.resize(closed ? kSpokes : kSpokes - 1, 3);
        Index f = 0;
        for (const Index k : order) {
            if (closed || k < kSpokes - 1) mesh.faces.row(f++) << k, (k + 1) % kSpokes, kSpokes;
        }
        const std::clock_t begun = std::clock();
        const OneRings rings = rings_of(mesh);
        EXPECT_LT(static_cast<double>(std::clock() - begun), 5.0 * CLOCKS_PER_SEC);
        std::vector<Index> around(kSpokes);
        std::iota(around.begin(), around.end(), 0);
        EXPECT_EQ(rotated_to(ring(rings, kSpokes), 0), around);
        EXPECT_EQ(rotated_to(ring(rings, 7), 8), (std::vector<Index>{8, kSpokes, 6}));
        EXPECT_EQ(rings.kinds[kSpokes], closed ? RingKind::kClosed : RingKind::kOpen);
        EXPECT_EQ(rings.detached_triangle_count, 0);
    }
}

TEST(OneRing, BowTieTakesItsLargestFan) {
    Mesh mesh;
    mesh.vertices = Positions::Random(7, 3);
    mesh.faces.resize(3, 3);
    mesh.faces << 0, 1, 2, 0, 2, 3, 0, 5, 6;
    const OneRings rings = rings_of(mesh);
    EXPECT_EQ(rings.kinds[0], RingKind::kNonManifold);
    EXPECT_EQ(rings.triangle_count(0), rings.valence(0) - 1);
    EXPECT_EQ(ring(rings, 0), (std::vector<Index>{1, 2, 3}));
}

TEST(OneRing, WhatFitsNoManifoldIsAFanOfItsOwn) {
    Mesh mesh;
    mesh.vertices = Positions::Random(5, 3);
    mesh.faces.resize(4, 3);
    mesh.faces << 0, 1, 2, 1, 0, 3, 0, 1, 4, 0, 1, 2;  // a third triangle on edge 0-1, and a duplicate
    const OneRings rings = rings_of(mesh);
    EXPECT_EQ(rings.detached_triangle_count, 2);
    EXPECT_EQ(rings.kinds[4], RingKind::kOpen);
    EXPECT_EQ(ring(rings, 4), (std::vector<Index>{0, 1}));
    EXPECT_EQ(rings.kinds[0], RingKind::kNonManifold);
    EXPECT_EQ(ring(rings, 0), (std::vector<Index>{3, 1, 2}));
}

TEST(OneRing, IsThatOfTheFirstSurfaceWhereASecondOneLiesOnIt) {
    const Mesh sheet = grid(5, 5, 0.0);
    Mesh both = sheet;
    both.faces.conservativeResize(2 * sheet.faces.rows(), 3);
    both.faces.bottomRows(sheet.faces.rows()) = sheet.faces.rowwise().reverse();
    const OneRings rings = rings_of(both);
    EXPECT_EQ(rings.vertices, rings_of(sheet).vertices);
    EXPECT_EQ(rings.detached_triangle_count, sheet.faces.rows());
    EXPECT_EQ(rings.kinds[12], RingKind::kClosed);
    EXPECT_EQ(rings.kinds[0], RingKind::kNonManifold);
}

TEST(OneRing, RefusesNumbersOutsideTheMeshAndATriangleThatNamesAVertexTwice) {
    Triangles faces(2, 3);
    const auto refusal = [&] { return message_of<InvalidInput>([&] { collect_one_rings(3, faces, Execution()); }); };
    faces << 0, 1, 2, 0, 1, 7;
    EXPECT_TRUE(contains(refusal(), "triangle 1 names vertex 7")) << refusal();
    faces.row(1) << 0, -1, 2;
    EXPECT_TRUE(contains(refusal(), "triangle 1 names vertex -1")) << refusal();
    faces.row(1) << 1, 2, 1;
    EXPECT_TRUE(contains(refusal(), "triangle 1 names a vertex twice")) << refusal();
}

}  // namespace
}  // namespace meanvalue::tests
