#include "meanvalue/optimise/ring_limit.h"

#include <numeric>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr Index kAround = 3000;

/// A region of its own, all free but for those named.
Region region_of(Index vertex_count, const Triangles& faces, const std::vector<Index>& fixed = {}) {
    Region region;
    for (Index v = 0; v < vertex_count; ++v)
        region.vertices.push_back(100 + v);
    region.positions = Positions::Zero(vertex_count, 3);
    region.faces = faces;
    region.is_fixed = flags(vertex_count, fixed);
    return region;
}

void require(const Region& region) {
    require_short_rings(region, region.is_fixed, Execution());
}

TEST(RingLimit, TakesTheLongestThereMayBeAndNoLongerOne) {
    EXPECT_NO_THROW(require_short_rings({}, {}));
    EXPECT_NO_THROW(require_short_rings({7}, {kMostNeighbours}));
    const std::string text = message_of<InvalidInput>([] {
        require_short_rings({7, 8, 9}, {kMostNeighbours, kMostNeighbours + 1, 5});
    });
    EXPECT_TRUE(contains(text, "vertex 8 has 2049 neighbors that may move, and at most 2048")) << text;
    EXPECT_TRUE(contains(text, "dissolve it")) << text;
}

TEST(RingLimit, AddsUpManyLongRingsAndNotShortOnes) {
    std::vector<Index> vertices(1000000), neighbours(vertices.size(), 99);
    std::iota(vertices.begin(), vertices.end(), 0);
    EXPECT_NO_THROW(require_short_rings(vertices, neighbours));
    std::fill_n(neighbours.begin(), 100, 1500);
    neighbours[40] = 1501;
    const std::string text = message_of<InvalidInput>([&] { require_short_rings(vertices, neighbours); });
    EXPECT_TRUE(contains(text, "vertex 40 has 1501 neighbors that may move, and too many others")) << text;
}

TEST(RingLimit, NamesTheVertexOfTheWholeMeshAndCountsOnlyNeighboursThatMayMove) {
    const Triangles fan = random_fan(kAround, 1).faces;
    const std::string text = message_of<InvalidInput>([&] { require(region_of(kAround + 1, fan)); });
    EXPECT_TRUE(contains(text, "vertex 100 has 3000 neighbors")) << text;
    EXPECT_NO_THROW(require(region_of(2049, random_fan(2048, 1).faces)));
    std::vector<Index> fixed;
    for (Index v = 1; v <= kAround; v += 2)
        fixed.push_back(v);
    EXPECT_NO_THROW(require(region_of(kAround + 1, fan, fixed)));
    // That the hub itself is fixed does not help: its row is there all the same.
    EXPECT_THROW(require(region_of(kAround + 1, fan, {0})), InvalidInput);
}

}  // namespace
}  // namespace meanvalue::tests
