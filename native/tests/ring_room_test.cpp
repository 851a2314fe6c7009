#include "meanvalue/optimise/ring_room.h"

#include <cmath>
#include <optional>

#include "meanvalue/deform/deformer.h"
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
    region.is_fixed.assign(vertex_count, 0);
    for (const Index v : fixed)
        region.is_fixed[v] = 1;
    return region;
}

/// A closed fan about vertex 0.
Triangles fan(Index valence) {
    Triangles faces(valence, 3);
    for (Index k = 0; k < valence; ++k)
        faces.row(k) << 0, k + 1, (k + 1) % valence + 1;
    return faces;
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
        EXPECT_TRUE(contains(text, "100 vertices have 100 neighbours or more")) << text;
        EXPECT_TRUE(contains(text, "vertex 40, with 1501")) << text;
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

TEST(RingRoom, NamesTheVertexOfTheWholeMesh) {
    const std::string text = message_of<InvalidInput>([] { require(region_of(kAround + 1, fan(kAround))); });
    EXPECT_TRUE(contains(text, "vertex 100 has 3000 neighbours")) << text;
    EXPECT_NO_THROW(require(region_of(2049, fan(2048))));
}

TEST(RingRoom, CountsOnlyNeighboursThatMayMove) {
    std::vector<Index> fixed;
    for (Index v = 1; v <= kAround; v += 2)
        fixed.push_back(v);
    EXPECT_NO_THROW(require(region_of(kAround + 1, fan(kAround), fixed)));
    // That the hub itself is fixed does not help: its row is there all the same.
    EXPECT_THROW(require(region_of(kAround + 1, fan(kAround), {0})), InvalidInput);
}

TEST(RingRoom, CountsFansThatMeetAtAPointOrAnEdgeOneByOne) {
    Triangles at_point(kAround, 3), at_edge(kAround, 3);
    for (Index k = 0; k < kAround; ++k) {
        at_point.row(k) << 0, 1 + 2 * k, 2 + 2 * k;
        at_edge.row(k) << 0, 1, 2 + k;
    }
    EXPECT_NO_THROW(require(region_of(2 * kAround + 1, at_point)));
    EXPECT_NO_THROW(require(region_of(kAround + 2, at_edge)));
}

class EveryMethod : public testing::TestWithParam<Method> {};

TEST_P(EveryMethod, RefusesAHubByName) {
    const Mesh mesh = capped_tube(kAround, 2, 1.0);
    Execution execution;
    const std::vector<Index> anchors = {0, kAround / 3, kAround / 2};
    const std::string text =
        message_of<InvalidInput>([&] { Deformer(binding_of(mesh, anchors, GetParam()), execution); });
    EXPECT_TRUE(contains(text, "neighbours that may move, and at most 2048")) << text;
    EXPECT_TRUE(contains(text, message("vertex ", 2 * kAround)) ||
                contains(text, message("vertex ", 2 * kAround + 1)))
        << text;
}

TEST_P(EveryMethod, SolvesForThePoleOfASphereOf160Segments) {
    const Mesh mesh = capped_tube(160, 4, 1.0);
    Execution execution;
    const std::vector<Index> anchors = {0, 50, 100, 480, 530, 580};
    Deformer deformer(binding_of(mesh, anchors, GetParam()), execution);
    EXPECT_GE(deformer.report().longest_ring, 160);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, 0.5, {1, 0, 0});
    const Solution solution = deformer.solve(rows_of(moved, anchors), {}, SolveOptions(), execution);
    EXPECT_LT(largest_distance(solution.vertices, moved), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::Values(Method::kFast, Method::kPaper, Method::kFull));

}  // namespace
}  // namespace meanvalue::tests
