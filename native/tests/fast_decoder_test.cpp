#include "meanvalue/decode/fast/fast_decoder.h"

#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

TEST(FastDecoder, AHandleThatMovesWithEverythingIsFollowedWithoutHarm) {
    // All anchors are one handle, so that the way is taken in steps as well.
    const Mesh mesh = capped_tube(16, 30, 8.0);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Binding binding = binding_of(mesh, anchors, Method::kFast, 1);
    binding.handles.assign(8, 0);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, 3.0, {5, -2, 1});
    const Positions found = solve(*bound(binding), rows_of(moved, anchors)).vertices;
    EXPECT_LT(largest_distance(found, moved), 1e-9 * mesh.diagonal());
}

TEST(FastDecoder, DoesNotDependOnUnitsOrPlace) {
    const Pose pose = two_ends("bend", capped_tube(16, 25, 8.0), Vector3::UnitX(), 1.0, {0, 2, -1});
    const Positions expected = solve(*bound_to(pose.mesh, pose.anchors), pose.targets).vertices;
    for (const double scale : {1e-3, 1e4}) {
        Mesh mesh = pose.mesh;
        mesh.vertices *= scale;
        const Positions scaled = solve(*bound_to(mesh, pose.anchors), scale * pose.targets).vertices;
        EXPECT_LT(largest_distance(scaled / scale, expected), 1e-6 * pose.mesh.diagonal()) << scale;
    }
    Mesh mesh = pose.mesh;
    const Eigen::RowVector3d shift(300, -200, 100);
    mesh.vertices.rowwise() += shift;
    const Positions shifted = solve(*bound_to(mesh, pose.anchors), pose.targets.rowwise() + shift).vertices;
    EXPECT_LT(largest_distance(shifted.rowwise() - shift, expected), 1e-6 * pose.mesh.diagonal());
}

/// With a coarse level, whose vertices are the same ones only if order and size turn with the mesh.
TEST(FastDecoder, DoesNotDependOnHowTheMeshIsTurned) {
    Mesh symmetric = capped_tube(40, 80, 8.0);
    symmetric.vertices.col(0) *= 1.4;
    for (const Mesh& mesh : {symmetric, with_noise(symmetric, 0.05, 3)}) {
        const Pose pose = two_ends("bend", mesh, Vector3::UnitX(), 1.0, {0, 2, -1});
        const Positions expected = solve(*bound_to(mesh, pose.anchors), pose.targets).vertices;
        for (const double angle_rad : {0.3, 1.0, 2.5}) {
            const auto turn = [&](const Positions& positions) {
                return moved_by_similarity(positions, 1.0, Vector3(1, -2, 0.5), angle_rad, Vector3::Zero());
            };
            Mesh turned = mesh;
            turned.vertices = turn(mesh.vertices);
            const Positions found = solve(*bound_to(turned, pose.anchors), turn(pose.targets)).vertices;
            EXPECT_LT(largest_distance(found, turn(expected)), 1e-4 * mesh.diagonal()) << angle_rad;
        }
    }
}

}  // namespace
}  // namespace meanvalue::tests
