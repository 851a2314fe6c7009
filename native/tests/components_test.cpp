#include "meanvalue/mesh/components.h"

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

int undetermined(const std::vector<Index>& fixed) {
    const Mesh mesh = grid(5, 5, 0.0);
    return find_components(mesh.vertices, mesh.faces, flags(25, fixed), Execution()).parts.at(0).undetermined;
}

TEST(Components, CountsWhatFixedPointsLeaveOpen) {
    EXPECT_EQ(undetermined({}), 7);
    EXPECT_EQ(undetermined({7}), 4);
    EXPECT_EQ(undetermined({7, 12}), 1);
    EXPECT_EQ(undetermined({0, 6, 12, 18}), 1);  // on the diagonal
    EXPECT_EQ(undetermined({0, 6, 7}), 0);
}

TEST(Components, CoincidentPointsCountOnce) {
    Mesh mesh = grid(5, 5, 0.0);
    mesh.vertices.row(6) = mesh.vertices.row(0);
    EXPECT_EQ(find_components(mesh.vertices, mesh.faces, flags(25, {0, 6}), Execution()).parts[0].undetermined, 4);
}

TEST(Components, PartsAreFoundInOrderOfTheirFirstVertex) {
    Mesh mesh = joined(grid(3, 3, 0.0), strip());
    mesh.vertices.conservativeResize(14, 3);  // a loose vertex
    mesh.vertices.row(13).setZero();
    const Components components = find_components(mesh.vertices, mesh.faces, flags(14, {0, 9, 10}), Execution());
    ASSERT_EQ(components.parts.size(), 3u);
    EXPECT_EQ(components.parts[0].vertex_count, 9);
    EXPECT_EQ(components.parts[1].first_vertex, 9);
    EXPECT_EQ(components.parts[1].free_count, 2);
    EXPECT_EQ(components.parts[1].fixed_count, 2);
    EXPECT_EQ(components.parts[2].vertex_count, 1);
    EXPECT_EQ(components.part_of[12], 1);
    EXPECT_EQ(components.fixed[1], (std::vector<Index>{9, 10}));
}

}  // namespace
}  // namespace meanvalue::tests
