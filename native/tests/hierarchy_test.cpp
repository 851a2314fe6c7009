#include "meanvalue/hierarchy/hierarchy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/predictor.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Hierarchy hierarchy_of(const Mesh& mesh, const std::vector<char>& is_fixed, const CoarseningOptions& options,
                       int threads = 1) {
    Execution execution;
    return build_hierarchy(rings_of(mesh), mesh.vertices, is_fixed, options, threads, execution);
}

Encoding splits_of(const Level& level, const Mesh& mesh, int threads = 1) {
    Execution execution;
    return encode(level.splits.rings, mesh.vertices, threads, execution);
}

std::vector<char> flags_of(const Mesh& mesh, const std::vector<Index>& vertices) {
    return flags(mesh.vertex_count(), vertices);
}

Hierarchy hierarchy_of(const Mesh& mesh, const std::vector<Index>& anchors,
                       const std::vector<Index>& level_sizes = {}, int threads = 1) {
    CoarseningOptions options;
    options.level_sizes = level_sizes;
    return hierarchy_of(mesh, flags_of(mesh, anchors), options, threads);
}

/// Puts the removed vertices back by equation 13.
Positions split_all(const Hierarchy& hierarchy, const Mesh& mesh, Positions positions, int threads = 1) {
    for (auto level = hierarchy.levels.rbegin(); level != hierarchy.levels.rend(); ++level)
        level->splits.apply(splits_of(*level, mesh, threads), positions, threads, Execution());
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

TEST_P(EveryKind, SplitsAndCarryingGiveBackTheShapeAndASimilarityOfIt) {
    const Mesh& mesh = GetParam();
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 8));
    EXPECT_GT(hierarchy.order.size(), mesh.vertices.rows() * 3 / 4u);
    const Positions moved = moved_by_similarity(mesh.vertices, 2.0, {1, 2, 3}, 2.5, {4, 5, 6});
    const auto carried = [&](int threads) {
        Positions positions = without_removed(hierarchy, moved);
        for (auto level = hierarchy.levels.rbegin(); level != hierarchy.levels.rend(); ++level)
            level->splits.carry(mesh.vertices, positions, threads, Execution());
        return positions;
    };
    const Positions rebuilt = split_all(hierarchy, mesh, without_removed(hierarchy, mesh.vertices));
    EXPECT_LT(largest_distance(rebuilt, mesh.vertices), 1e-9 * mesh.diagonal());
    const Positions rebuilt_moved = split_all(hierarchy, mesh, without_removed(hierarchy, moved));
    EXPECT_LT(largest_distance(rebuilt_moved, moved), 1e-9 * 2.0 * mesh.diagonal());
    EXPECT_LT(largest_distance(carried(1), moved), 1e-9 * 2.0 * mesh.diagonal());
    EXPECT_EQ(carried(1), carried(3));
}

TEST_P(EveryKind, RingsStayBoundedStencilsRegularAndAnchorsInPlace) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Hierarchy hierarchy = hierarchy_of(mesh, anchors);
    EXPECT_LE(hierarchy.longest_ring(), 16);
    for (const Index anchor : anchors)
        EXPECT_EQ(std::count(hierarchy.order.begin(), hierarchy.order.end(), anchor), 0);
    const Splits& splits = hierarchy.base().splits;
    ASSERT_EQ(splits.vertices.size(), hierarchy.order.size());
    const Encoding encoding = splits_of(hierarchy.base(), mesh);
    for (const Index v : splits.vertices) {
        const EncodedRing ring = encoding.ring_of(v);
        double amplification = 0.0;
        for (Index k = 0; k < ring.valence; ++k)
            amplification += std::abs(ring.weights[k]);
        EXPECT_LE(amplification, 4.0);
        EXPECT_EQ(ring.normal_weights, nullptr);
    }
}

/// Level 0 with at most `free_count` free vertices, fixed ones thinned out.
Hierarchy thinned(const Mesh& mesh, const std::vector<char>& is_fixed, Index free_count,
                  const std::vector<Index>& handles = {}, int threads = 1) {
    CoarseningOptions options;
    options.level_sizes = {free_count};
    options.down_to_base = false;
    options.thin_out_fixed = true;
    options.handles = handles;
    return hierarchy_of(mesh, is_fixed, options, threads);
}

/// The vertices with the flag that are still there.
std::vector<Index> kept(const Hierarchy& hierarchy, const std::vector<char>& flags) {
    std::vector<char> left = flags;
    for (const Index v : hierarchy.order)
        left[v] = 0;
    std::vector<Index> result;
    for (std::size_t v = 0; v < left.size(); ++v) {
        if (left[v]) result.push_back(static_cast<Index>(v));
    }
    return result;
}

/// The middle one of the singular values, over the largest: zero where the points are on a line.
double flatness(const Mesh& mesh, const std::vector<Index>& vertices) {
    Positions points = rows_of(mesh.vertices, vertices);
    points.rowwise() -= points.colwise().mean().eval();
    const Eigen::Vector3d values = (points.transpose() * points).eigenvalues().real();
    std::array<double, 3> sorted = {values[0], values[1], values[2]};
    std::sort(sorted.begin(), sorted.end());
    return std::sqrt(std::max(sorted[1], 0.0) / sorted[2]);
}

std::vector<char> left_half(const Mesh& mesh) {
    std::vector<char> flags(mesh.vertex_count(), 0);
    const double middle = mesh.vertices.col(0).mean();
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        flags[v] = mesh.vertices(v, 0) < middle;
    return flags;
}

TEST_P(EveryKind, ThinnedOutToo) {
    const Mesh& mesh = GetParam();
    const std::vector<char> is_fixed = left_half(mesh);
    const Hierarchy hierarchy = thinned(mesh, is_fixed, mesh.vertex_count() / 16);
    const Positions rebuilt = split_all(hierarchy, mesh, without_removed(hierarchy, mesh.vertices));
    EXPECT_LT(largest_distance(rebuilt, mesh.vertices), 1e-9 * mesh.diagonal());
    EXPECT_LE(hierarchy.longest_ring(), 16);
    const Positions predicted = predict_all(hierarchy.base().encoding, mesh.vertices, 1, Execution());
    EXPECT_LT(largest_distance(predicted, mesh.vertices), 1e-9 * mesh.diagonal());
    // Both halves are about equally dense: what is left of them is of like numbers.
    const std::size_t fixed = kept(hierarchy, is_fixed).size();
    EXPECT_LT(fixed, 2.5 * hierarchy.base().free_count + 8);
    EXPECT_GT(fixed, hierarchy.base().free_count / 3);
}

TEST_P(EveryKind, TheOrderDoesNotDependOnTheScale) {
    // On regular meshes many costs are equal but for rounding, which is another at each scale.
    Mesh mesh = GetParam();
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        mesh.vertices.row(v) +=
            1e-3 * mesh.diagonal() * Vector3(std::sin(7 * v), std::sin(11 * v), std::sin(13 * v)).transpose();
    const std::vector<char> is_fixed = flags_of(mesh, spread_vertices(mesh, 8));
    const std::vector<Index> order = thinned(mesh, is_fixed, mesh.vertex_count() / 5).order;
    for (const double scale : {1e-3, 1.1, 3.7}) {
        Mesh other = mesh;
        other.vertices *= scale;
        EXPECT_EQ(thinned(other, is_fixed, mesh.vertex_count() / 5).order, order) << scale;
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryKind,
                         testing::Values(sphere(4), grid(20, 18, 0.02), torus(30, 16), with_noise(sphere(4), 0.1, 1),
                                         joined(sphere(3), grid(12, 12, 0.03)), capped_tube(16, 40, 12.0)));

TEST(Hierarchy, ATorusKeepsWhatItsTopologyNeeds) {
    const Mesh mesh = torus(24, 12);
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 4));
    // The smallest triangulation of a torus has 7 vertices.
    EXPECT_GE(hierarchy.base().free_count + 4, 7);
    EXPECT_LE(hierarchy.base().free_count, 12);
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
    // They say nothing of vertices that are gone.
    for (const Level& level : hierarchy.levels) {
        for (const Index v : level.encoding.guarded)
            EXPECT_EQ(std::count(hierarchy.order.begin(), hierarchy.order.end(), v), 0);
    }
}

TEST(Hierarchy, IsTheSameForAnyNumberOfThreads) {
    // In the plane all costs are equal, and a round removes thousands; the cap's middle is a hub.
    const Mesh noisy = with_noise(torus(90, 60), 0.1, 2);
    const Mesh plane = grid(300, 300, 0.0);
    const Mesh hub = capped_tube(6000, 6, 1.0);
    const std::array<std::function<Hierarchy(int)>, 4> cases = {
        [&](int threads) { return hierarchy_of(noisy, spread_vertices(noisy, 6), {300}, threads); },
        [&](int threads) { return thinned(noisy, left_half(noisy), 200, {}, threads); },
        [&](int threads) { return thinned(plane, flags_of(plane, spread_vertices(plane, 5)), 500, {}, threads); },
        [&](int threads) { return thinned(hub, flags_of(hub, {hub.vertex_count() - 1}), 500, {}, threads); }};
    for (const auto& built : cases) {
        const Hierarchy one = built(1);
        const Hierarchy four = built(4);
        EXPECT_EQ(one.order, four.order);
        for (std::size_t level = 0; level < one.levels.size(); ++level) {
            EXPECT_EQ(one.levels[level].splits.vertices, four.levels[level].splits.vertices);
            EXPECT_EQ(one.levels[level].splits.rings.vertices, four.levels[level].splits.rings.vertices);
            EXPECT_EQ(one.levels[level].encoding.heights, four.levels[level].encoding.heights);
        }
    }
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
        if (on_border) {
            EXPECT_GE(border_neighbours, 2) << v;
        }
    }
}

TEST(Hierarchy, SplitsGiveTheSameBitsInAnyOrderAndForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(200, 100), 0.1, 2);
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 8), {600});
    const Positions start = with_noise(mesh, 0.3, 7).vertices;
    const Positions one = split_all(hierarchy, mesh, start, 1);
    EXPECT_EQ(one, split_all(hierarchy, mesh, start, 2));
    EXPECT_EQ(one, split_all(hierarchy, mesh, start, 7));
    // One by one, last removed first.
    Positions serial = start;
    const Encoding fine = splits_of(hierarchy.levels[0], mesh);
    const Encoding coarse = splits_of(hierarchy.levels[1], mesh);
    for (auto v = hierarchy.order.rbegin(); v != hierarchy.order.rend(); ++v)
        serial.row(*v) = predict((coarse.predictable(*v) ? coarse : fine).ring_of(*v), serial);
    EXPECT_EQ(one, serial);
}

TEST(Hierarchy, SparseAnchorsStayInEveryLevel) {
    const Mesh mesh = with_noise(sphere(4), 0.1, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 40);
    const Hierarchy hierarchy = thinned(mesh, flags_of(mesh, anchors), 60);
    EXPECT_EQ(kept(hierarchy, flags_of(mesh, anchors)).size(), anchors.size());
}

TEST(Hierarchy, EveryHandleKeepsVerticesThatAreNotOnALine) {
    // Two handles that touch, and a third vertex by vertex along a line, which goes round a corner.
    const Mesh mesh = grid(60, 40, 0.001);
    std::vector<char> is_fixed(mesh.vertex_count(), 0);
    std::vector<Index> handles(mesh.vertex_count(), 0);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Index column = v % 60;
        const Index row = v / 60;
        if (column < 16) handles[v] = 1;
        if (column >= 16 && column < 24) handles[v] = 2;
        if ((column == 40 && row > 5 && row < 20) || (row == 20 && column >= 40 && column < 55)) handles[v] = 3;
        is_fixed[v] = handles[v] != 0;
    }
    const Hierarchy hierarchy = thinned(mesh, is_fixed, 20, handles);
    for (Index handle = 1; handle <= 3; ++handle) {
        std::vector<char> of_handle(mesh.vertex_count(), 0);
        for (Index v = 0; v < mesh.vertex_count(); ++v)
            of_handle[v] = handles[v] == handle;
        const std::vector<Index> left = kept(hierarchy, of_handle);
        EXPECT_GE(left.size(), 4u) << handle;
        EXPECT_LT(left.size(), 60u) << handle;
        EXPECT_GT(flatness(mesh, left), 0.1) << handle;
    }
}

TEST(Hierarchy, TakesMessyMeshes) {
    Mesh mesh = joined(with_noise(grid(14, 14, 0.02), 0.2, 5), sphere(2));
    const Index first = static_cast<Index>(mesh.faces.rows());
    mesh.faces.conservativeResize(first + 4, 3);
    // A third triangle on an edge, a duplicate, one turned inside out, and one that joins the parts.
    mesh.faces.row(first) << 30, 31, 170;
    mesh.faces.row(first + 1) = mesh.faces.row(3);
    mesh.faces.row(first + 2) << 100, 115, 101;
    mesh.faces.row(first + 3) << 60, 61, 200;
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);  // a loose vertex
    mesh.vertices.bottomRows(1) << 9, 9, 9;
    for (const bool is_fixed_half : {false, true}) {
        const std::vector<char> is_fixed =
            is_fixed_half ? left_half(mesh) : flags_of(mesh, spread_vertices(mesh, 10));
        for (const Index size : {0, 20}) {
            const Hierarchy hierarchy = thinned(mesh, is_fixed, size);
            EXPECT_GT(hierarchy.order.size(), 80u);
            const Positions rebuilt = split_all(hierarchy, mesh, without_removed(hierarchy, mesh.vertices));
            EXPECT_LT(largest_distance(rebuilt, mesh.vertices), 1e-9 * mesh.diagonal());
        }
    }
}

TEST(Hierarchy, CancelsAtAnyPlaceOfCoarseningAndSplits) {
    const Mesh mesh = with_noise(torus(140, 100), 0.05, 1);
    const OneRings rings = rings_of(mesh);
    const std::vector<char> is_fixed = flags_of(mesh, spread_vertices(mesh, 8));
    CoarseningOptions options;
    options.level_sizes = {400};
    const auto build = [&](Execution& execution) {
        return build_hierarchy(rings, mesh.vertices, is_fixed, options, 2, execution);
    };
    EXPECT_EQ(cancelled_everywhere(build), (std::vector<std::string>{"", "build hierarchy", "encode"}));
    Execution execution;
    const Hierarchy hierarchy = build(execution);
    for (int check = 1; check < 8; ++check) {
        Execution cancelled;
        cancelled.cancel_at_check(check);
        Positions positions = mesh.vertices;
        EXPECT_THROW(hierarchy.levels.front().splits.carry(mesh.vertices, positions, 1, cancelled), Cancelled);
    }
}

TEST(Hierarchy, AHubIsLookedAtOnlyOnceItsRingIsShort) {
    // With a cost for each spoke at each change of the ring this took a minute at 1500, and days at this size.
    const Mesh mesh = capped_tube(6000, 3, 1.0);
    const Hierarchy hierarchy = hierarchy_of(mesh, spread_vertices(mesh, 8));
    EXPECT_GT(hierarchy.order.size(), mesh.vertex_count() * 9 / 10u);
}

}  // namespace
}  // namespace meanvalue::tests
