#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

OneRings rings_of(const Mesh& mesh) {
    return collect_one_rings(TriangleMesh(mesh.vertex_count(), mesh.faces, Execution()), Execution());
}

Hierarchy hierarchy_of(const Mesh& mesh, const std::vector<char>& is_fixed, const CoarseningOptions& options,
                       int threads = 1) {
    Execution execution;
    return build_hierarchy(rings_of(mesh), mesh.vertices, is_fixed, options, threads, execution);
}

std::vector<char> flags_of(const Mesh& mesh, const std::vector<Index>& vertices) {
    std::vector<char> flags(mesh.vertex_count(), 0);
    for (const Index v : vertices)
        flags[v] = 1;
    return flags;
}

Hierarchy hierarchy_of(const Mesh& mesh, const std::vector<Index>& anchors,
                       const std::vector<Index>& level_sizes = {}, int threads = 1) {
    CoarseningOptions options;
    options.level_sizes = level_sizes;
    return hierarchy_of(mesh, flags_of(mesh, anchors), options, threads);
}

/// Puts the removed vertices back by equation 13.
Positions split_all(const Hierarchy& hierarchy, Positions positions, int threads = 1) {
    hierarchy.split(static_cast<int>(hierarchy.levels.size()) - 1, -1, positions, threads, Execution());
    return positions;
}

/// The removed free vertices at the origin.
Positions without_removed(const Hierarchy& hierarchy, Positions positions) {
    for (const Level& level : hierarchy.levels) {
        for (const Index v : level.splits.vertices)
            positions.row(v).setZero();
    }
    return positions;
}

class EveryKind : public testing::TestWithParam<Mesh> {};

TEST_P(EveryKind, CollapseThenSplitIsTheIdentity) {
    const Mesh& mesh = GetParam();
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 8));
    EXPECT_GT(hierarchy.order.size(), mesh.vertices.rows() * 3 / 4u);
    const Positions rebuilt = split_all(hierarchy, without_removed(hierarchy, mesh.vertices));
    EXPECT_LT(largest_distance(rebuilt, mesh.vertices), 1e-9 * mesh.diagonal());
}

TEST_P(EveryKind, SplitsCommuteWithASimilarity) {
    const Mesh& mesh = GetParam();
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 8));
    const Positions moved = moved_by_similarity(mesh.vertices, 2.0, {1, 2, 3}, 2.5, {4, 5, 6});
    const Positions rebuilt = split_all(hierarchy, without_removed(hierarchy, moved));
    EXPECT_LT(largest_distance(rebuilt, moved), 1e-9 * 2.0 * mesh.diagonal());
}

TEST_P(EveryKind, RingsStayBoundedAndAnchorsStay) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Hierarchy hierarchy = hierarchy_of(mesh, anchors);
    EXPECT_LE(hierarchy.longest_ring(), 16);
    for (const Index anchor : anchors) {
        EXPECT_EQ(std::count(hierarchy.order.begin(), hierarchy.order.end(), anchor), 0);
    }
}

TEST_P(EveryKind, EveryRemovedStencilIsRegular) {
    const Hierarchy hierarchy = hierarchy_of(GetParam(), spread_vertices(GetParam(), 8));
    const Splits& splits = hierarchy.base().splits;
    ASSERT_EQ(splits.vertices.size(), hierarchy.order.size());
    for (Index k = 0; k < splits.size(); ++k) {
        const EncodedRing ring = splits.ring_of(k);
        double amplification = 0.0;
        for (Index k = 0; k < ring.valence; ++k)
            amplification += std::abs(ring.weights[k]);
        EXPECT_LE(amplification, 4.0);
        EXPECT_EQ(ring.normal_weights, nullptr);
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryKind,
                         testing::Values(sphere(4), grid(20, 18, 0.02), torus(30, 16), with_noise(sphere(4), 0.1, 1),
                                         joined(sphere(3), grid(12, 12, 0.03)), capped_tube(16, 40, 12.0)));

TEST(Hierarchy, ATorusKeepsWhatItsTopologyNeeds) {
    const Mesh mesh = torus(24, 12);
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 4));
    // The smallest triangulation of a torus has 7 vertices.
    EXPECT_GE(hierarchy.base_unknowns.size() + 4, 7u);
    EXPECT_LE(hierarchy.base_unknowns.size(), 12u);
}

TEST(Hierarchy, LevelsHaveTheSizesAskedForAndEncodeAllTheirVertices) {
    const Mesh mesh = sphere(4);
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    const Hierarchy hierarchy = hierarchy_of(mesh, anchors, {400, 100});
    ASSERT_EQ(hierarchy.levels.size(), 3u);
    const Index free_count = mesh.vertex_count() - 6;
    EXPECT_EQ(free_count - static_cast<Index>(hierarchy.levels[0].removed_count), 400);
    EXPECT_EQ(free_count - static_cast<Index>(hierarchy.levels[1].removed_count), 100);
    Index encoded = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        encoded += hierarchy.levels[1].encoding.predictable(v);
    EXPECT_EQ(encoded, 106);
    const Positions predicted = predict_all(hierarchy.levels[1].encoding, mesh.vertices, 1, Execution());
    EXPECT_LT(largest_distance(predicted, mesh.vertices), 1e-12 * mesh.diagonal());
}

TEST(Hierarchy, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(60, 50), 0.1, 2);
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    const Hierarchy one = hierarchy_of(mesh, anchors, {300}, 1);
    const Hierarchy four = hierarchy_of(mesh, anchors, {300}, 4);
    EXPECT_EQ(one.order, four.order);
    for (int level = 0; level < 2; ++level) {
        EXPECT_EQ(one.levels[level].splits.vertices, four.levels[level].splits.vertices);
        EXPECT_EQ(one.levels[level].splits.weights, four.levels[level].splits.weights);
    }
    EXPECT_EQ(one.levels[0].encoding.heights, four.levels[0].encoding.heights);
}

TEST(Hierarchy, ABoundaryStaysWhereItWas) {
    const Mesh mesh = grid(15, 15, 0.0);
    const Hierarchy hierarchy = hierarchy_of(mesh, {0, 14, 210, 224}, {20});
    // What is left at the level still covers the square: its area is that of the whole.
    const Encoding& level = hierarchy.levels[0].encoding;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (!level.predictable(v)) continue;
        const bool on_border = v % 15 == 0 || v % 15 == 14 || v < 15 || v >= 210;
        Index border_neighbours = 0;
        for (Index k = level.ring_offsets[v]; k < level.ring_offsets[v + 1]; ++k) {
            const Index j = level.ring[k];
            border_neighbours += j % 15 == 0 || j % 15 == 14 || j < 15 || j >= 210;
        }
        if (on_border) EXPECT_GE(border_neighbours, 2) << v;
    }
}

TEST(Hierarchy, Cancels) {
    const Mesh mesh = sphere(3);
    Execution execution;
    execution.cancel();
    const std::vector<char> is_fixed(mesh.vertex_count(), 0);
    EXPECT_THROW(build_hierarchy(rings_of(mesh), mesh.vertices, is_fixed, {}, 1, execution), Cancelled);
}

TEST(CollapseCost, PrefersWhatKeepsTheVolumeAndTheAngles) {
    // A flat fan with one raised spike: removing a flat vertex is cheap, the spike is not.
    Mesh mesh = grid(5, 5, 0.0);
    const RingMesh rings(rings_of(mesh), Execution());
    const RingView ring = rings.ring(12);
    const double flat = collapse_cost(mesh.vertices, 12, 13, ring);
    mesh.vertices(12, 2) = 1.0;
    EXPECT_GT(collapse_cost(mesh.vertices, 12, 13, ring), 10 * flat);
    // Merging along the grid leaves better angles than merging towards a far corner of a sheared ring.
    mesh.vertices(12, 2) = 0.0;
    mesh.vertices(12, 0) = 2.9;
    EXPECT_LT(collapse_cost(mesh.vertices, 12, 13, ring), collapse_cost(mesh.vertices, 12, 11, ring));
}

TEST(CollapseCost, PutsOffWhatTurnsATriangleOver) {
    // A ring with a dent: merging into the dent's far side folds a triangle.
    Mesh mesh = grid(5, 5, 0.0);
    mesh.vertices.row(7) << 2.0, 2.4, 0.0;  // pushed past the middle vertex at (2, 2)
    mesh.vertices.row(12) << 2.0, 2.6, 0.0;
    const RingMesh rings(rings_of(mesh), Execution());
    const RingView ring = rings.ring(12);
    EXPECT_GT(collapse_cost(mesh.vertices, 12, 13, ring), 1e3);
}

}  // namespace
}  // namespace meanvalue::tests
