// What artists expect of the fast method's shapes, at the default rigidity.

#include <algorithm>
#include <cmath>

#include "meanvalue/linalg/procrustes.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

Vector3 corner(const Positions& shape, const Triangles& faces, Index face, int k) {
    return shape.row(faces(face, k % 3));
}

Vector3 normal(const Positions& shape, const Triangles& faces, Index face) {
    const Vector3 a = corner(shape, faces, face, 0);
    return (corner(shape, faces, face, 1) - a).cross(corner(shape, faces, face, 2) - a);
}

/// Signed volume that the triangles of a closed mesh enclose.
double volume_of(const Positions& shape, const Triangles& faces) {
    double sum = 0.0;
    for (Index face = 0; face < faces.rows(); ++face) {
        sum += corner(shape, faces, face, 0).dot(corner(shape, faces, face, 1).cross(corner(shape, faces, face, 2)));
    }
    return sum / 6.0;
}

/// How many triangles point against what their surroundings make of their rest normal: the rotations that fit the
/// edges around its corners, averaged, carry it. A fold of one triangle counts, a part that turned as a whole does
/// not.
Index flipped_triangles(const Positions& shape, const Mesh& rest) {
    std::vector<Matrix3> moments(rest.vertex_count(), Matrix3::Zero());
    for (Index face = 0; face < rest.faces.rows(); ++face) {
        for (int k = 0; k < 3; ++k) {
            const Matrix3 product =
                (corner(shape, rest.faces, face, k + 1) - corner(shape, rest.faces, face, k)) *
                (corner(rest.vertices, rest.faces, face, k + 1) - corner(rest.vertices, rest.faces, face, k))
                    .transpose();
            moments[rest.faces(face, k)] += product;
            moments[rest.faces(face, (k + 1) % 3)] += product;
        }
    }
    Index count = 0;
    for (Index face = 0; face < rest.faces.rows(); ++face) {
        Matrix3 sum = Matrix3::Zero();
        for (int k = 0; k < 3; ++k)
            sum += fit_rotation(moments[rest.faces(face, k)]);
        const Vector3 expected = fit_rotation(sum) * normal(rest.vertices, rest.faces, face);
        if (expected.dot(normal(shape, rest.faces, face)) <= 0.0) ++count;
    }
    return count;
}

/// The angle about z that turns the vertices `rows` from rest to shape at best, each about their middle.
double turn_about_z(const Positions& shape, const Positions& rest, const std::vector<Index>& rows) {
    Positions from = rows_of(rest, rows);
    Positions to = rows_of(shape, rows);
    from.rowwise() -= from.colwise().mean().eval();
    to.rowwise() -= to.colwise().mean().eval();
    const Eigen::Matrix2d moments = to.leftCols<2>().transpose() * from.leftCols<2>();
    return std::atan2(moments(1, 0) - moments(0, 1), moments.trace());
}

/// A bar held by its two end caps, of which the upper one moves.
struct HeldBar {
    Index across, along;
    Mesh mesh;
    std::vector<Index> anchors;
    double length = 0.0;

    HeldBar(Index across, Index along) : across(across), along(along), mesh(bar(across, along)) {
        mesh.vertices.leftCols(2).array() -= 0.5;
        length = static_cast<double>(along) / across;
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            if (is_lower(v) || is_upper(v)) anchors.push_back(v);
        }
    }
    bool is_lower(Index v) const { return mesh.vertices(v, 2) < 1e-9; }
    bool is_upper(Index v) const { return mesh.vertices(v, 2) > length - 1e-9; }

    Positions targets(const Vector3& axis, double angle_rad, const Vector3& translation) const {
        const Vector3 pivot(0, 0, length);
        const Positions moved = moved_by_similarity(mesh.vertices.rowwise() - pivot.transpose(), 1.0, axis, angle_rad,
                                                    pivot + translation);
        Positions result = rows_of(mesh.vertices, anchors);
        for (std::size_t k = 0; k < anchors.size(); ++k) {
            if (is_upper(anchors[k])) result.row(k) = moved.row(anchors[k]);
        }
        return result;
    }

    /// How far the turns of the cross-sections, from below, are off the straight line to `angle_rad`.
    double unevenness(const Positions& shape, double angle_rad) const {
        double worst = 0.0;
        double last = 0.0;
        for (Index layer = 1; layer < along; ++layer) {
            std::vector<Index> section;
            for (Index v = 0; v < mesh.vertex_count(); ++v) {
                if (std::abs(mesh.vertices(v, 2) * across - layer) < 0.01) section.push_back(v);
            }
            double turn = turn_about_z(shape, mesh.vertices, section);
            turn += 2 * kPi * std::round((last - turn) / (2 * kPi));  // layers differ by less than half a turn
            last = turn;
            worst = std::max(worst, std::abs(turn - angle_rad * layer / along));
        }
        return worst;
    }
};

void expect_evenly_twisted(const HeldBar& held, const Positions& shape, double angle_rad, double least_volume) {
    const double volume = volume_of(shape, held.mesh.faces) / volume_of(held.mesh.vertices, held.mesh.faces);
    EXPECT_LT(held.unevenness(shape, angle_rad), 10 * kPi / 180);
    EXPECT_EQ(flipped_triangles(shape, held.mesh), 0);
    EXPECT_GT(volume, least_volume);
    EXPECT_LT(volume, 1.05);
}

TEST(FastShapes, ATwistedBarTurnsEvenly) {
    // The second one has a coarse level.
    for (const HeldBar& held : {HeldBar(4, 32), HeldBar(12, 72)}) {
        const auto deformer = bound_to(held.mesh, held.anchors);
        EXPECT_EQ(deformer->report().level_sizes.size(), held.across == 12 ? 2u : 1u);
        for (const double angle_deg : {-135.0, 90.0, 135.0}) {
            const double angle_rad = angle_deg * kPi / 180;
            expect_evenly_twisted(held, solve(*deformer, held.targets({0, 0, 1}, angle_rad, {0, 0, 0})).vertices,
                                  angle_rad, 0.85);
        }
    }
}

TEST(FastShapes, AHalfTurnReachedByDraggingIsAsEven) {
    for (const HeldBar& held : {HeldBar(4, 24), HeldBar(12, 72)}) {
        const auto deformer = bound_to(held.mesh, held.anchors);
        Positions shape = held.mesh.vertices;
        Deformer::Drag drag(*deformer, PositionsView(held.mesh.vertices));
        for (int step = 1; step <= 18; ++step) {
            const double angle_rad = step * kPi / 18;
            shape = solve_next(drag, held.targets({0, 0, 1}, angle_rad, {0, 0, 0})).vertices;
        }
        expect_evenly_twisted(held, shape, kPi, 0.8);  // a half turn draws in more
    }
}

TEST(FastShapes, HandlesOfFewAnchorsAreFollowed) {
    // Without handles, single anchors have no turn that could be followed.
    const HeldBar held(4, 32);
    std::vector<Index> anchors;
    std::vector<Index> handles;
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < held.anchors.size(); ++k) {
        const Index v = held.anchors[k];
        if (std::abs(held.mesh.vertices(v, 0)) < 0.4 || std::abs(held.mesh.vertices(v, 1)) < 0.4) continue;
        anchors.push_back(v);
        handles.push_back(held.is_upper(v) ? 1 : 0);
        places.push_back(k);
    }
    ASSERT_EQ(anchors.size(), 8u);
    for (const double angle_deg : {120.0, 150.0}) {
        const double angle_rad = angle_deg * kPi / 180;
        const Positions all = held.targets({0, 0, 1}, angle_rad, {0, 0, 0});
        Positions targets(8, 3);
        for (Index k = 0; k < 8; ++k)
            targets.row(k) = all.row(static_cast<Eigen::Index>(places[k]));
        Execution execution;
        Binding binding = binding_of(held.mesh, anchors, Method::kFast, 1);
        binding.handles = handles;
        Deformer with(binding, execution);
        const Solution followed = solve(with, targets);
        expect_evenly_twisted(held, followed.vertices, angle_rad, 0.8);
        EXPECT_LE(followed.energy, 1.001 * solve(*bound_to(held.mesh, anchors), targets).energy);
    }
}

TEST(FastShapes, AThreeQuarterBendReachedByDraggingIsSmooth) {
    const HeldBar held(4, 48);
    const auto deformer = bound_to(held.mesh, held.anchors);
    Positions shape = held.mesh.vertices;
    Deformer::Drag drag(*deformer, PositionsView(held.mesh.vertices));
    const double bend_rad = 1.5 * kPi;
    for (int step = 1; step <= 27; ++step) {
        // The upper end of an arc of the bar's length.
        const double angle_rad = bend_rad * step / 27;
        const double radius = held.length / angle_rad;
        const Vector3 end(0, -radius * (1 - std::cos(angle_rad)), radius * std::sin(angle_rad));
        shape = solve_next(drag, held.targets({1, 0, 0}, angle_rad, end - Vector3(0, 0, held.length))).vertices;
    }
    const double volume = volume_of(shape, held.mesh.faces) / volume_of(held.mesh.vertices, held.mesh.faces);
    EXPECT_EQ(flipped_triangles(shape, held.mesh), 0);
    EXPECT_NEAR(volume, 1.0, 0.15);
    // Middles of the layers lie on the arc.
    const double radius = held.length / bend_rad;
    for (Index layer = 1; layer < held.along; ++layer) {
        Vector3 middle = Vector3::Zero();
        int count = 0;
        for (Index v = 0; v < held.mesh.vertex_count(); ++v) {
            if (std::abs(held.mesh.vertices(v, 2) * held.across - layer) > 0.01) continue;
            middle += Vector3(shape.row(v));
            ++count;
        }
        middle /= count;
        const double angle_rad = bend_rad * layer / held.along;
        const Vector3 expected(0, -radius * (1 - std::cos(angle_rad)), radius * std::sin(angle_rad));
        EXPECT_LT((middle - expected).norm(), 0.03 * held.mesh.diagonal()) << layer;
    }
}

TEST(FastShapes, ASymmetricBendComesOutSymmetric) {
    // Both ends of a tube turned towards each other: a mirror image of itself in the plane half-way.
    for (const Index around : {16, 32}) {
        const Index along = around == 16 ? 41 : 121;
        const Mesh mesh = capped_tube(around, along, 10.0);
        std::vector<Index> anchors;
        for (Index v = 0; v < 2 * around; ++v) {
            anchors.push_back(v);
            anchors.push_back((along - 2) * around + v);
        }
        const auto deformer = bound_to(mesh, anchors);
        const Positions lower = moved_by_similarity(mesh.vertices, 1.0, {1, 0, 0}, 1.0, {0, 0, 1.0});
        Positions centred = mesh.vertices;
        centred.col(2).array() -= 10.0;
        const Positions upper = moved_by_similarity(centred, 1.0, {1, 0, 0}, -1.0, {0, 0, 9.0});
        Positions targets = rows_of(lower, anchors);
        for (std::size_t k = 1; k < anchors.size(); k += 2)
            targets.row(k) = upper.row(anchors[k]);
        const Positions shape = solve(*deformer, targets).vertices;
        double worst = 0.0;
        for (Index v = 0; v < along * around; ++v) {
            const Index layer = v / around;
            Vector3 mirrored = shape.row((along - 1 - layer) * around + v % around);
            mirrored.z() = 10.0 - mirrored.z();
            worst = std::max(worst, (Vector3(shape.row(v)) - mirrored).norm());
        }
        EXPECT_LT(worst, 0.01 * mesh.diagonal()) << around;
        EXPECT_EQ(flipped_triangles(shape, mesh), 0);
    }
}

}  // namespace
}  // namespace meanvalue::tests
