// What is worn goes along with what is posed: clothes, buttons, eyes.
#include "meanvalue/follow/follower.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/mesh/triangle_tree.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr double kMiddle = 4.0;  // where tubes are bent: from there on, along z

Mesh moved(Mesh mesh, double scale, const Vector3& by) {
    mesh.vertices = (scale * mesh.vertices).rowwise() + by.transpose();
    return mesh;
}

/// An open tube about z with the radius, from low to high.
Mesh sleeve(double radius, double low, double high, Index around = 24, Index along = 25) {
    Mesh mesh = grid(around, along, 0.0);
    mesh.vertices.resize(around * along, 3);
    std::vector<Eigen::Matrix<Index, 1, 3>> faces;
    for (Index r = 0; r < along; ++r) {
        for (Index c = 0; c < around; ++c) {
            const double angle_rad = 2.0 * kPi * (c + 0.5 * (r % 2)) / around;
            mesh.vertices.row(r * around + c) << radius * std::cos(angle_rad), radius * std::sin(angle_rad),
                low + (high - low) * r / (along - 1);
            if (r == 0) continue;
            const Index next = (c + 1) % around, before = (r - 1) * around, here = r * around;
            if (r % 2 == 1) {
                faces.push_back({before + c, before + next, here + c});
                faces.push_back({before + next, here + next, here + c});
            } else {
                faces.push_back({before + c, here + next, here + c});
                faces.push_back({before + c, before + next, here + next});
            }
        }
    }
    mesh.faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
        mesh.faces.row(static_cast<Eigen::Index>(f)) = faces[f];
    return mesh;
}

/// An arm of radius 1 from z = 0 to 10.
Mesh arm() {
    return moved(capped_tube(32, 60, 10.0), 1.0, Vector3::Zero());
}

/// Bent in the plane of x and z about an axis at x = -1.6.
Positions bent(const Positions& rest, double angle_rad) {
    constexpr double kRadius = 1.6;
    const double end = kMiddle + kRadius * angle_rad;
    Positions result = rest;
    for (Index v = 0; v < rest.rows(); ++v) {
        const double z = rest(v, 2);
        const double angle = (std::clamp(z, kMiddle, end) - kMiddle) / kRadius;
        const double beyond = z < kMiddle ? z - kMiddle : std::max(0.0, z - end);
        const double out = kRadius + rest(v, 0);
        result(v, 0) = out * std::cos(angle) - beyond * std::sin(angle) - kRadius;
        result(v, 2) = kMiddle + out * std::sin(angle) + beyond * std::cos(angle);
    }
    return result;
}

Follower follower_of(const Mesh& carrier, const Mesh& worn, FollowKind kind = FollowKind::kAuto, int threads = 1) {
    FollowBinding binding(carrier.vertices, carrier.faces, worn.vertices, worn.faces);
    binding.kind = kind;
    binding.threads = threads;
    return Follower(binding);
}

Positions normals_of(const Mesh& mesh, const Positions& positions) {
    Positions normals = Positions::Zero(positions.rows(), 3);
    for (Index f = 0; f < mesh.faces.rows(); ++f) {
        const Vector3 a = positions.row(mesh.faces(f, 0));
        const Vector3 area =
            (Vector3(positions.row(mesh.faces(f, 1))) - a).cross(Vector3(positions.row(mesh.faces(f, 2))) - a);
        for (int c = 0; c < 3; ++c)
            normals.row(mesh.faces(f, c)) += area.transpose();
    }
    return normals.rowwise().normalized();
}

/// How far each point is above the surface, along its normals.
std::vector<double> heights(const Positions& points, const Mesh& mesh, const Positions& positions) {
    const Positions normals = normals_of(mesh, positions);
    const std::vector<Index> one(positions.rows(), 0);
    const TriangleTree tree(positions, mesh.faces, one, Execution());
    std::vector<double> result;
    for (Index v = 0; v < points.rows(); ++v) {
        const Vector3 point = points.row(v);
        const TriangleTree::Place place = tree.nearest({point}, 1e9);
        Vector3 normal = Vector3::Zero();
        for (int c = 0; c < 3; ++c)
            normal += place.weights[c] * normals.row(mesh.faces(place.triangle, c)).transpose();
        result.push_back((point - place.point).dot(normal));
    }
    return result;
}

/// Lengths of edges in the last, as shares of those at rest; ascending.
std::vector<double> stretches(const Mesh& mesh, const Positions& posed) {
    std::vector<double> result;
    for (Index f = 0; f < mesh.faces.rows(); ++f) {
        for (int c = 0; c < 3; ++c) {
            const Index a = mesh.faces(f, c), b = mesh.faces(f, (c + 1) % 3);
            result.push_back((posed.row(a) - posed.row(b)).norm() /
                             (mesh.vertices.row(a) - mesh.vertices.row(b)).norm());
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

double percentile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double share_below(const std::vector<double>& values, double limit) {
    return static_cast<double>(std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; })) /
           static_cast<double>(values.size());
}

/// A sleeve, a button on it, and one on the arm.
Mesh worn() {
    const Mesh clothes = joined(sleeve(1.04, 1.0, 8.0), moved(sphere(1), 0.06, {1.08, 0.0, 3.0}));
    return joined(clothes, moved(sphere(1), 0.06, {1.02, 0.0, 9.0}));
}

TEST(Follower, RestAndSimilaritiesTakeAllAlong) {
    const Mesh body = arm();
    const Mesh clothes = worn();
    const Follower follower = follower_of(body, clothes);
    EXPECT_EQ(follower.kinds(),
              (std::vector<FollowKind>{FollowKind::kCloth, FollowKind::kRigid, FollowKind::kRigid}));
    const double size = body.diagonal();
    EXPECT_LT(largest_distance(follower.follow(body.vertices), clothes.vertices), 1e-11 * size);
    for (const double scale : {1.0, 0.3, 7.0}) {
        const auto placed = [&](const Positions& of) {
            return moved_by_similarity(of, scale, {1.0, -2.0, 0.4}, 2.1, {30.0, -10.0, 5.0});
        };
        EXPECT_LT(largest_distance(follower.follow(placed(body.vertices)), placed(clothes.vertices)),
                  1e-11 * size * scale);
    }
}

TEST(Follower, BitsDoNotDependOnThreads) {
    const Mesh body = arm();
    const Mesh clothes = joined(sleeve(1.04, 1.0, 9.0, 60, 80), worn());
    const Positions posed = bent(body.vertices, 1.7);
    const Follower one = follower_of(body, clothes);
    const Follower four = follower_of(body, clothes, FollowKind::kAuto, 4);
    EXPECT_EQ(one.follow(posed), four.follow(posed));
    EXPECT_EQ(one.follow(posed, 3), one.follow(posed));
}

TEST(Follower, ASleeveBendsWithItsArm) {
    const Mesh body = arm();
    const Mesh clothes = sleeve(1.04, 1.0, 9.0, 40, 60);
    const Follower follower = follower_of(body, clothes);
    for (const double angle_rad : {0.6, 1.2, 1.9}) {
        const Positions posed = bent(body.vertices, angle_rad);
        const Positions result = follower.follow(posed);
        EXPECT_LT(share_below(heights(result, body, posed), -1e-3), 0.0045) << angle_rad;
        // Vertices of the arm between the sleeve's ends stay below it.
        Positions covered(body.vertex_count(), 3);
        Index count = 0;
        for (Index v = 0; v < body.vertex_count(); ++v) {
            if (body.vertices(v, 2) > 1.2 && body.vertices(v, 2) < 8.8) covered.row(count++) = posed.row(v);
        }
        covered.conservativeResize(count, 3);
        const std::vector<double> depths = heights(covered, clothes, result);
        EXPECT_GT(share_below(depths, 1e-3), 0.997) << angle_rad;
        const std::vector<double> of_body = stretches(body, posed);
        const std::vector<double> of_clothes = stretches(clothes, result);
        EXPECT_LT(percentile(of_clothes, 0.99), 1.1 * percentile(of_body, 0.99)) << angle_rad;
        // Where the bend itself has it, nearly.
        EXPECT_LT(largest_distance(result, bent(clothes.vertices, angle_rad)), 0.12) << angle_rad;
    }
}

TEST(Follower, ASkirtHasNoSpikesAndFarLimbsDoNotMoveIt) {
    const Mesh leg = moved(capped_tube(24, 40, 8.0), 0.5, {-0.7, 0.0, 0.0});
    const Mesh legs = joined(leg, moved(leg, 1.0, {1.4, 0.0, 0.0}));
    const Mesh skirt = [] {
        Mesh mesh = sleeve(1.0, 0.2, 2.5, 48, 30);
        mesh.vertices.col(0) *= 1.35;
        mesh.vertices.col(1) *= 0.65;
        return mesh;
    }();
    const Follower follower = follower_of(legs, skirt);
    ASSERT_EQ(follower.kinds().front(), FollowKind::kCloth);
    Positions raised = legs.vertices;
    for (Index v = 0; v < leg.vertex_count(); ++v) {
        const double angle_rad = 0.9 * std::clamp((3.0 - raised(v, 2)) / 2.0, 0.0, 1.0);
        const double z = raised(v, 2) - 3.0;
        const double y = raised(v, 1);
        raised(v, 1) = std::cos(angle_rad) * y + std::sin(angle_rad) * -z;
        raised(v, 2) = 3.0 - std::sin(angle_rad) * y + std::cos(angle_rad) * z;
    }
    const Positions result = follower.follow(raised);
    const std::vector<double> edges = stretches(skirt, result);
    EXPECT_LT(percentile(edges, 0.99), 2.4);
    EXPECT_LT(edges.back(), 3.5);
    // What lies on the other leg alone hardly moves.
    for (Index v = 0; v < skirt.vertex_count(); ++v) {
        if (skirt.vertices(v, 0) > 0.9) EXPECT_LT((result.row(v) - skirt.vertices.row(v)).norm(), 0.02);
    }
    // A limb beside both moves nothing.
    const Mesh beside = joined(legs, moved(leg, 1.0, {6.0, 0.0, 0.0}));
    Positions far = beside.vertices;
    far.bottomRows(leg.vertex_count()).col(1).array() += 2.0;
    EXPECT_LT(largest_distance(follower_of(beside, skirt).follow(far), skirt.vertices), 1e-9);
}

TEST(Follower, ClothBetweenLegsThatTurnApartStaysBetweenThem) {
    const Mesh leg = moved(capped_tube(24, 40, 8.0), 0.5, {-0.53, 0.0, 0.0});
    const Mesh legs = joined(leg, moved(leg, 1.0, {1.06, 0.0, 0.0}));
    Mesh cloth = grid(80, 60, 0.0);  // over the front of both and into the gap
    for (Index v = 0; v < cloth.vertex_count(); ++v) {
        const double x = 2.0 * (v % 80) / 79.0 - 1.0;
        const double aside = std::abs(x) - 0.53;
        const double depth = std::sqrt(std::max(0.01, 0.52 * 0.52 - aside * aside));
        const Index row = v / 80;
        cloth.vertices.row(v) << x, -depth, 0.5 + 1.5 * row / 59.0;
    }
    const Follower follower = follower_of(legs, cloth, FollowKind::kCloth);
    for (const double angle_rad : {0.3, 0.6, 0.9, 1.2}) {
        Positions posed = legs.vertices;
        for (Index v = 0; v < posed.rows(); ++v) {
            const double way = v < leg.vertex_count() ? 1.0 : -1.0;
            const double angle = way * angle_rad * std::clamp((2.5 - posed(v, 2)) / 1.5, 0.0, 1.0);
            const double y = posed(v, 1), z = posed(v, 2) - 2.5;
            posed(v, 1) = std::cos(angle) * y - std::sin(angle) * z;
            posed(v, 2) = 2.5 + std::sin(angle) * y + std::cos(angle) * z;
        }
        const Positions result = follower.follow(posed);
        EXPECT_GT((result.colwise().minCoeff() - posed.colwise().minCoeff()).minCoeff(), -0.1) << angle_rad;
        EXPECT_LT((result.colwise().maxCoeff() - posed.colwise().maxCoeff()).maxCoeff(), 0.1) << angle_rad;
    }
}

TEST(Follower, AButtonGoesWithTheClothThatItIsOn) {
    const Mesh body = arm();
    // On a wide sleeve, whose folds are its own.
    const Mesh clothes = joined(sleeve(1.25, 1.0, 8.0), moved(sphere(1), 0.05, {1.29, 0.0, 4.6}));
    const Positions result = follower_of(body, clothes).follow(bent(body.vertices, 1.4));
    const Index count = sphere(1).vertex_count();
    const Index sleeve_count = clothes.vertex_count() - count;
    const Mesh cloth = sleeve(1.25, 1.0, 8.0);
    const Vector3 before = clothes.vertices.bottomRows(count).colwise().mean();
    const Vector3 after = result.bottomRows(count).colwise().mean();
    const auto height = [&](const Vector3& point, const Positions& of) {
        const Positions one = point.transpose();
        return heights(one, cloth, of).front();
    };
    EXPECT_NEAR(height(after, result.topRows(sleeve_count)), height(before, cloth.vertices), 0.02);
    const Mesh button = moved(sphere(1), 0.05, Vector3::Zero());
    const std::vector<double> edges = stretches(button, result.bottomRows(count));
    EXPECT_NEAR(edges.front(), edges.back(), 1e-9);  // rigid but for its size
}

TEST(Follower, ADragIsAsSmoothAsTheBodys) {
    const Mesh body = arm();
    const Mesh clothes = sleeve(1.04, 1.0, 9.0, 40, 60);
    const Follower follower = follower_of(body, clothes);
    std::vector<Positions> bodies, garments;
    for (int frame = 0; frame < 40; ++frame) {
        bodies.push_back(bent(body.vertices, 0.045 * frame));
        garments.push_back(follower.follow(bodies.back()));
    }
    const auto second_difference = [](const std::vector<Positions>& frames) {
        double most = 0.0;
        for (std::size_t k = 1; k + 1 < frames.size(); ++k)
            most = std::max(most, (frames[k - 1] - 2.0 * frames[k] + frames[k + 1]).rowwise().norm().maxCoeff());
        return most;
    };
    EXPECT_LT(second_difference(garments), 2.0 * second_difference(bodies));
}

TEST(Follower, AMeshSplitAtItsSeamsStaysWhole) {
    const Mesh body = arm();
    const Mesh whole = sleeve(1.04, 1.0, 9.0);
    Mesh split = whole;
    const Index count = whole.vertex_count();
    split.vertices.resize(2 * count, 3);
    split.vertices << whole.vertices, whole.vertices;
    for (Index f = 0; f < whole.faces.rows(); ++f) {
        const bool is_left = (whole.vertices(whole.faces.row(f), 0).array().mean()) < 0.0;
        if (is_left) split.faces.row(f).array() += count;
    }
    const Positions posed = bent(body.vertices, 1.4);
    const Positions result = follower_of(body, split).follow(posed);
    const Positions expected = follower_of(body, whole).follow(posed);
    for (Index f = 0; f < whole.faces.rows(); ++f) {
        for (int c = 0; c < 3; ++c)
            EXPECT_LT((result.row(split.faces(f, c)) - expected.row(whole.faces(f, c))).norm(), 1e-7);
    }
}

TEST(Follower, OddMeshesFollowToo) {
    const Mesh body = arm();
    Mesh cloth = sleeve(1.04, 2.0, 8.0);
    Mesh odd = joined(cloth, moved(cloth, 1.0, Vector3::Zero()));     // two layers in one place
    odd = joined(odd, sleeve(0.8, 2.0, 6.0));                         // inside
    odd = joined(odd, moved(triangle(), 1.0, {1.1, 0.0, 5.0}));       // three vertices
    odd = joined(odd, moved(grid(4, 4, 0.0), 0.0, {1.1, 0.0, 5.0}));  // all in one place
    const Index first = odd.vertex_count();
    odd.vertices.conservativeResize(first + 2, 3);  // lone ones
    odd.vertices.bottomRows(2) << 1.2, 0.0, 3.0, 40.0, 0.0, 0.0;
    odd.faces.conservativeResize(odd.faces.rows() + 2, 3);  // a fin, and a face again
    odd.faces.bottomRows(2) << 0, 1, 5 * 24, 0, 1, 24;
    for (const FollowKind kind : {FollowKind::kAuto, FollowKind::kCloth, FollowKind::kRigid}) {
        const Follower follower = follower_of(body, odd, kind);
        EXPECT_LT(largest_distance(follower.follow(body.vertices), odd.vertices), 1e-10);
        const Positions result = follower.follow(bent(body.vertices, 1.5));
        EXPECT_TRUE(result.allFinite());
        EXPECT_LT((result.topRows(cloth.vertex_count()) - odd.vertices.topRows(cloth.vertex_count()))
                      .rowwise()
                      .norm()
                      .maxCoeff(),
                  12.0);
    }
    const Follower nothing = follower_of(body, moved(Mesh{"", Positions(0, 3), Triangles(0, 3)}, 1.0, {}));
    EXPECT_EQ(nothing.follow(body.vertices).rows(), 0);
    // A carrier of one triangle, and one that is all in one place.
    EXPECT_TRUE(follower_of(triangle(), cloth, FollowKind::kCloth).follow(triangle().vertices).allFinite());
    const Mesh point = moved(sphere(1), 0.0, {1.0, 0.0, 0.0});
    EXPECT_TRUE(follower_of(point, cloth, FollowKind::kCloth).follow(point.vertices).allFinite());
}

TEST(Follower, AHubOfManyFacesTakesNoSquareOfThem) {
    const Mesh body = capped_tube(8000, 3, 1.0);
    const Mesh cloth = moved(body, 1.05, Vector3::Zero());
    const Follower follower = follower_of(body, cloth, FollowKind::kCloth);
    EXPECT_LT(largest_distance(follower.follow(body.vertices), cloth.vertices), 1e-10);
}

TEST(Follower, ACarrierModeledFromBothSidesHasNoNormals) {
    Mesh body = sleeve(1.0, 0.0, 9.0);
    const auto count = body.faces.rows();
    body.faces.conservativeResize(2 * count, 3);
    body.faces.bottomRows(count) = body.faces.topRows(count).rowwise().reverse();
    const Mesh cloth = sleeve(1.04, 1.0, 8.0);
    const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    const auto turned = [&](const Positions& positions) { return Positions(positions * turn.transpose()); };
    const Follower follower = follower_of(body, cloth, FollowKind::kCloth);
    EXPECT_LT(largest_distance(follower.follow(turned(body.vertices)), turned(cloth.vertices)), 1e-9);
}

TEST(Follower, WrongInputIsNamed) {
    const Mesh body = sphere(1);
    Mesh cloth = sphere(1);
    const auto text = [&](const Mesh& carrier, const Mesh& of) {
        return message_of<InvalidInput>([&] { follower_of(carrier, of); });
    };
    Mesh bad = cloth;
    bad.faces(3, 1) = 400;
    EXPECT_TRUE(contains(text(body, bad), "faces: triangle 3 names vertex 400"));
    EXPECT_TRUE(contains(text(bad, cloth), "carrier_faces: triangle 3"));
    bad = cloth;
    bad.vertices(2, 1) = NAN;
    EXPECT_TRUE(contains(text(body, bad), "vertices[2]"));
    bad = body;
    bad.faces.resize(0, 3);
    EXPECT_TRUE(contains(text(bad, cloth), "carrier_faces has no triangles"));
    const Follower follower = follower_of(body, cloth);
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { follower.follow(body.vertices.topRows(3)); }),
                         "carrier_posed has 3 positions"));
}

TEST(Follower, CanBeCancelled) {
    const Mesh body = arm();
    const Mesh clothes = worn();
    const FollowBinding binding(body.vertices, body.faces, clothes.vertices, clothes.faces);
    EXPECT_FALSE(cancelled_everywhere([&](Execution& execution) { Follower(binding, execution); }).empty());
    const Follower follower(binding);
    cancelled_everywhere([&](Execution& execution) { follower.follow(body.vertices, 1, execution); });
}

}  // namespace
}  // namespace meanvalue::tests
