#include "meanvalue/decode/fast/handle_paths.h"

#include <algorithm>

#include "tests/support.h"

namespace meanvalue::tests {
namespace {

struct Motion {
    Matrix3 rotation;
    Vector3 translation;

    Motion(const Vector3& axis, double angle_rad, const Vector3& moved_by)
        : rotation(Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix()), translation(moved_by) {}
    Vector3 apply(const Vector3& point) const { return rotation * point + translation; }
};

const Vector3 kPoints[] = {{0, 0, 0}, {1, 0, 0}, {-2, 3, 1}, {0.5, -4, 2}};

TEST(ScrewOf, TakesAWholeMotionAndHalfOfItTwice) {
    for (const Vector3& axis : {Vector3(0, 0, 1), Vector3(1, 2, 3), Vector3(-1, 0.2, 0)}) {
        for (const double angle_deg : {0.0, 1e-9, 1e-4, 0.1, 5.0, 90.0, 135.0, 179.9, 180.0}) {
            for (const Vector3& translation :
                 {Vector3(0, 0, 0), Vector3(3, -1, 2), Vector3(axis), Vector3(1e-9, 0, 0)}) {
                const Motion motion(axis, angle_deg * kPi / 180, translation);
                const ScrewMotion screw = screw_of(motion.rotation, motion.translation);
                // Turns of less than a millionth are dropped; then what is left out is as small.
                const double tolerance = angle_deg > 0.0 && angle_deg < 1e-4 ? 1e-9 : 1e-8;
                for (const Vector3& point : kPoints) {
                    EXPECT_LT((screw.apply(point, 0.0) - point).norm(), tolerance) << angle_deg;
                    EXPECT_LT((screw.apply(point, 1.0) - motion.apply(point)).norm(), tolerance) << angle_deg;
                    const Vector3 half = screw.apply(point, 0.5);
                    EXPECT_LT((screw.apply(half, 0.5) - motion.apply(point)).norm(), tolerance) << angle_deg;
                }
                EXPECT_NEAR(screw.angle_rad, angle_deg * kPi / 180, 1e-7);
            }
        }
    }
}

TEST(ScrewOf, ATurnAboutACentreKeepsTheDistanceFromIt) {
    const Vector3 centre(3, 1, -2);
    const Motion turn({0, 1, 0}, 2.5, {0, 0, 0});
    const ScrewMotion screw = screw_of(turn.rotation, centre - turn.rotation * centre);
    for (const double fraction : {0.1, 0.5, 0.9}) {
        EXPECT_LT((screw.apply(centre, fraction) - centre).norm(), 1e-12);
        for (const Vector3& point : kPoints)
            EXPECT_NEAR((screw.apply(point, fraction) - centre).norm(), (point - centre).norm(), 1e-12);
    }
}

TEST(ScrewOf, TheAngleIsAtMostAHalfTurn) {
    const Motion motion({0, 0, 1}, 1.5 * kPi, {0, 0, 1});
    const ScrewMotion screw = screw_of(motion.rotation, motion.translation);
    EXPECT_NEAR(screw.angle_rad, 0.5 * kPi, 1e-12);
    EXPECT_LT((screw.axis + Vector3::UnitZ()).norm(), 1e-12);
    EXPECT_LT((screw.apply({1, 0, 0}, 1.0) - Vector3(0, -1, 1)).norm(), 1e-12);
}

/// A grid of 9 x 6 vertices whose two outer columns at each side are fixed.
struct TwoEnds {
    Mesh mesh = grid(9, 6, 0.1);
    Encoding encoding = encoding_of(mesh);
    std::vector<char> is_fixed = std::vector<char>(54, 0);
    std::vector<Index> left, right;

    TwoEnds() {
        for (Index row = 0; row < 6; ++row) {
            for (const Index column : {0, 1, 7, 8}) {
                is_fixed[9 * row + column] = 1;
                (column < 4 ? left : right).push_back(9 * row + column);
            }
        }
    }
    HandlePaths pieces(const std::vector<Index>& handles = {}) const {
        return {encoding, mesh.vertices, is_fixed, handles, mesh.diagonal()};
    }
    /// Half of `motion` is a screw's for the right end; nothing else moves.
    void expect_half_way(const HandlePaths::Path& path, const Motion& motion, const Positions& begin) const {
        Positions positions = begin;
        path.place(0.5, positions);
        const ScrewMotion screw = screw_of(motion.rotation, motion.translation);
        for (const Index v : right)
            EXPECT_LT((Vector3(positions.row(v)) - screw.apply(begin.row(v), 0.5)).norm(), 1e-9) << v;
        for (Index v = 0; v < 54; ++v) {
            if (std::count(right.begin(), right.end(), v) > 0) continue;
            EXPECT_LT((positions.row(v) - begin.row(v)).norm(), 1e-9) << v;
        }
    }
    /// The rest pose with the right end moved.
    Positions placed(const Motion& motion) const {
        Positions result = mesh.vertices;
        for (const Index v : right)
            result.row(v) = motion.apply(mesh.vertices.row(v));
        return result;
    }
};

TEST(HandlePaths, ClustersJoinedByEdgesFollowScrewsOfTheirOwn) {
    const TwoEnds ends;
    const Motion first({0, 1, 0}, 2.0, {1, 0, 3});
    const HandlePaths pieces = ends.pieces();
    const HandlePaths::Path path = pieces.path_to(ends.placed(first));
    EXPECT_NEAR(path.largest_angle_rad(), 2.0, 1e-9);
    ends.expect_half_way(path, first, ends.mesh.vertices);
}

TEST(HandlePaths, FixedVerticesAreExactlyAtTheEndOfTheWay) {
    const TwoEnds ends;
    Positions placed = ends.placed({{1, 1, 0}, kPi, {0.1, 0.2, 0.3}});
    placed.row(ends.right[0]) += Eigen::RowVector3d(1e-5, 0, 0);  // still as good as rigid
    const HandlePaths pieces = ends.pieces();
    Positions positions = ends.mesh.vertices;
    pieces.path_to(placed).place(1.0, positions);
    EXPECT_EQ(positions, placed);
}

TEST(HandlePaths, ThoseThatAreNotRigidGoStraight) {
    const TwoEnds ends;
    Positions placed = ends.mesh.vertices;
    for (const Index v : ends.right)
        placed.row(v) *= -1.5;
    const HandlePaths pieces = ends.pieces();
    const HandlePaths::Path path = pieces.path_to(placed);
    EXPECT_EQ(path.largest_angle_rad(), 0.0);
    Positions positions = ends.mesh.vertices;
    path.place(0.25, positions);
    EXPECT_LT(largest_distance(positions, ends.mesh.vertices + 0.25 * (placed - ends.mesh.vertices)), 1e-12);
}

TEST(HandlePaths, VerticesWithoutAPlaceGoAlongWithTheirPiece) {
    const TwoEnds ends;
    const Motion motion({0, 1, 0}, 2.5, {1, 0, 3});
    Positions placed = ends.placed(motion);
    std::vector<char> is_free(54, 0);
    for (const Index v : {ends.right[0], ends.right[5]}) {
        is_free[v] = 1;
        placed.row(v) = Eigen::RowVector3d(4, 5, 6);
    }
    const HandlePaths pieces = ends.pieces();
    EXPECT_EQ(pieces.path_to(placed).largest_angle_rad(), 0.0) << "a vertex off its place makes a piece bend";
    const HandlePaths::Path path = pieces.path_to(placed, is_free);
    EXPECT_NEAR(path.largest_angle_rad(), 2.5, 1e-9);
    ends.expect_half_way(path, motion, ends.mesh.vertices);
    Positions positions = ends.mesh.vertices;
    path.place(1.0, positions);
    EXPECT_LT(largest_distance(positions, ends.placed(motion)), 1e-9);
}

TEST(HandlePaths, AHandleHoldsVerticesFarApartTogether) {
    // Single vertices have no turn of their own; as one handle they have.
    TwoEnds ends;
    ends.is_fixed = flags(54, {0, 8, 45, 53, 22});
    const std::vector<Index> handles(54, 3);
    const Motion motion({1, 2, 0}, 1.2, {0, 0, 1});
    Positions placed = ends.mesh.vertices;
    for (Index v = 0; v < 54; ++v) {
        if (ends.is_fixed[v]) placed.row(v) = motion.apply(ends.mesh.vertices.row(v));
    }
    EXPECT_EQ(ends.pieces().path_to(placed).largest_angle_rad(), 0.0);
    EXPECT_NEAR(ends.pieces(handles).path_to(placed).largest_angle_rad(), 1.2, 1e-9);
}

TEST(HandlePaths, HandlesDivideWhatEdgesJoin) {
    TwoEnds ends;
    ends.is_fixed.assign(54, 1);
    std::vector<Index> handles(54, 0);
    for (const Index v : ends.right)
        handles[v] = 1;
    const Positions placed = ends.placed({{0, 1, 0}, 1.0, {0, 0, 0}});
    EXPECT_EQ(ends.pieces().path_to(placed).largest_angle_rad(), 0.0);  // one piece, which is not rigid
    EXPECT_NEAR(ends.pieces(handles).path_to(placed).largest_angle_rad(), 1.0, 1e-9);
}

TEST(HandlePaths, OneAndTwoVerticesAndNoneAtAllGoStraight) {
    TwoEnds ends;
    ends.is_fixed.assign(54, 0);
    Positions positions = ends.mesh.vertices;
    const HandlePaths none = ends.pieces();
    none.path_to(positions).place(0.5, positions);
    EXPECT_EQ(positions, ends.mesh.vertices);
    ends.is_fixed = flags(54, {0, 1, 30});
    Positions placed = ends.mesh.vertices;
    placed.row(0).swap(placed.row(1));
    placed.row(30) *= 2.0;
    const HandlePaths few = ends.pieces();
    few.path_to(placed).place(0.5, positions);
    EXPECT_LT(largest_distance(positions, 0.5 * (placed + ends.mesh.vertices)), 1e-12);
}

TEST(HandlePaths, FarFromTheOriginTinyTurnsAreAsExact) {
    TwoEnds ends;
    const Vector3 offset(1e4, -2e4, 3e4);
    ends.mesh.vertices.rowwise() += offset.transpose();
    for (const double angle_rad : {3e-7, 3e-6, 1e-3}) {
        const Motion turn({0, 0, 1}, angle_rad, {0, 0, 0});
        const Motion about_here({0, 0, 1}, angle_rad, offset - turn.rotation * offset);
        const HandlePaths pieces = ends.pieces();
        Positions positions = ends.mesh.vertices;
        pieces.path_to(ends.placed(about_here)).place(0.5, positions);
        // Nothing goes farther than the turn takes it.
        EXPECT_LT(largest_distance(positions, ends.mesh.vertices), angle_rad * ends.mesh.diagonal() + 1e-9)
            << angle_rad;
    }
}

}  // namespace
}  // namespace meanvalue::tests
