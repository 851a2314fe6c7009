#include "meanvalue/mesh/surface_ways.h"

#include <cmath>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Arms of length 2 on both sides of a ball, around z, and `sleeves` about the upper ones: rings of `columns`
/// vertices.
SurfaceWays figure(Index rings, Index columns, int sleeves) {
    std::vector<Vector3> points;
    std::vector<Index> edges, corners;
    const auto add_lathe = [&](Index count, const auto& profile) {
        const auto first = static_cast<Index>(points.size());
        for (Index row = 0; row < count; ++row) {
            const auto [radius, height] = profile(row / (count - 1.0));
            for (Index k = 0; k < columns; ++k) {
                const double turn = 6.283185307179586 * k / columns;
                points.emplace_back(radius * std::cos(turn), radius * std::sin(turn), height);
                const Index a = first + row * columns + k, b = first + row * columns + (k + 1) % columns;
                edges.insert(edges.end(), {a, b});
                if (row + 1 == count) continue;
                edges.insert(edges.end(), {a, a + columns});
                edges.insert(edges.end(), {a, b + columns});
                corners.insert(corners.end(), {a, b, b + columns, a, b + columns, a + columns});
            }
        }
    };
    add_lathe(rings, [](double share) {
        const double height = 5.8 * share;
        const double away = std::abs(height - 2.9);
        const double arm = 0.1 * std::min(1.0, (2.9 - away) / 0.1 + 0.05);
        return std::make_pair(std::max(arm, std::sqrt(std::max(0.0, 0.81 - away * away))), height);
    });
    for (int k = 0; k < sleeves; ++k)
        add_lathe(rings / 6, [](double share) { return std::make_pair(0.11, 0.4 + share); });
    Positions positions(static_cast<Index>(points.size()), 3);
    for (std::size_t v = 0; v < points.size(); ++v)
        positions.row(static_cast<Index>(v)) = points[v];
    const Triangles triangles =
        Eigen::Map<const Triangles>(corners.data(), static_cast<Index>(corners.size() / 3), 3);
    const auto count = static_cast<Index>(edges.size() / 2);
    return SurfaceWays(positions, Eigen::Map<const SurfaceWays::Edges>(edges.data(), count, 2), triangles, 0.03, 2,
                       Execution());
}

TEST(SurfaceWays, ALimbIsAsLongOnAMeshOfManyVertices) {
    for (const int sleeves : {0, 1}) {
        const SurfaceWays coarse = figure(180, 24, sleeves), fine = figure(1440, 192, sleeves);
        for (const double height : {0.0, 0.5, 1.0}) {
            const Index ring = static_cast<Index>(height / 5.8 * 180);
            const double expected = coarse.limb(24 * ring, 0.0, 6.0);
            EXPECT_NEAR(expected, 2.0 - height, 0.4) << height;
            EXPECT_NEAR(fine.limb(192 * 8 * ring, 0.0, 6.0) / expected, 1.0, 0.13) << height << " " << sleeves;
        }
        EXPECT_EQ(coarse.limb(24 * 90, 0.0, 6.0), 0.0) << "on the body";
        EXPECT_EQ(fine.limb(192 * 720, 0.0, 6.0), 0.0) << "on the body";
    }
}

}  // namespace
}  // namespace meanvalue::tests
