#include "meanvalue/optimise/ring_room.h"

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
    require_room_for_rings(region, region.is_fixed, kNumberPairs, Execution());
}

TEST(RingRoom, TakesTheLongestThereMayBeAndNoLongerOne) {
    RingRoom room(kBlockPairs);
    room.add(7, RingRoom::kMostNeighbours);
    EXPECT_NO_THROW(room.require());
    room.add(8, RingRoom::kMostNeighbours + 1);
    room.add(9, 5);
    const std::string text = message_of<InvalidInput>([&] { room.require(); });
    EXPECT_TRUE(contains(text, "vertex 8 has 2049 neighbours that may move, and at most 2048")) << text;
    EXPECT_TRUE(contains(text, "dissolve it")) << text;
}

TEST(RingRoom, AddsUpWhatManyLongRingsNeed) {
    for (const PairBytes& bytes : {kBlockPairs, kNumberPairs, kNoPairs}) {
        RingRoom room(bytes);
        for (Index v = 0; v < 100; ++v)
            room.add(v, v == 40 ? 1501 : 1500);
        if (bytes.in_long_rows == 0.0) {
            EXPECT_NO_THROW(room.require());
            continue;
        }
        const std::string text = message_of<InvalidInput>([&] { room.require(); });
        EXPECT_TRUE(contains(text, "GB, more than the 10")) << text;
        EXPECT_TRUE(contains(text, "40, with 1501")) << text;
    }
}

TEST(RingRoom, AddsUpShortRingsForMethodsThatKeepBlocks) {
    RingRoom blocks(kBlockPairs), numbers(kNumberPairs);
    for (Index v = 0; v < 4000000; ++v) {
        blocks.add(v, 6);
        numbers.add(v, 6);
    }
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { blocks.require(); }), "restrict the region of influence"));
    EXPECT_NO_THROW(numbers.require());
}

TEST(RingRoom, NamesTheVertexOfTheWholeMeshAndCountsOnlyNeighboursThatMayMove) {
    const Triangles fan = random_fan(kAround, 1).faces;
    const std::string text = message_of<InvalidInput>([&] { require(region_of(kAround + 1, fan)); });
    EXPECT_TRUE(contains(text, "vertex 100 has 3000 neighbours")) << text;
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
