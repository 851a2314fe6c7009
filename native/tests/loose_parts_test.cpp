// Parts without an anchor: carried along by the nearest surface that is held, or left at rest.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/sequence/sequence.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

Mesh moved(Mesh mesh, double scale, const Vector3& by) {
    mesh.vertices = (scale * mesh.vertices).rowwise() + by.transpose();
    return mesh;
}

/// A head with two eyes that hold an iris each, on its surface at +x, and a hat above it.
struct Head {
    Mesh mesh = sphere(3);
    Index head_count = mesh.vertex_count();
    Index eye_count = sphere(1).vertex_count();
    std::vector<Index> low;   // anchors: the neck
    std::vector<Index> high;  // and the crown
    std::vector<Index> anchors;

    Head() {
        for (const double side : {-0.35, 0.35}) {
            mesh = joined(mesh, moved(sphere(1), 0.2, {0.88, side, 0.1}));
            mesh = joined(mesh, moved(sphere(1), 0.1, {1.0, side, 0.1}));
        }
        for (Index v = 0; v < head_count; ++v) {
            if (mesh.vertices(v, 2) < -0.8) low.push_back(v);
            if (mesh.vertices(v, 2) > 0.6) high.push_back(v);
        }
        anchors = low;
        anchors.insert(anchors.end(), high.begin(), high.end());
    }

    Binding binding(LooseRule rule) const {
        Binding binding{mesh.vertices, mesh.faces, anchors};
        binding.loose = rule;
        return binding;
    }
    Positions turned(double angle) const {
        Positions targets = rows_of(mesh.vertices, anchors);
        const Eigen::AngleAxisd turn(angle, Vector3::UnitZ());
        for (std::size_t k = low.size(); k < anchors.size(); ++k)
            targets.row(k) = (turn * Vector3(targets.row(k))).transpose();
        return targets;
    }
    /// Rows of loose part `part`, from 0.
    Positions part(const Positions& of, Index number) const {
        return of.middleRows(head_count + number * eye_count, eye_count);
    }
};

Positions solved(const Binding& binding, const Positions& targets, const std::optional<PositionsView>& start = {}) {
    Execution execution;
    return bound(binding)->solve(targets, start, {}, execution).vertices;
}

/// Of a mesh whose first part alone is held.
LooseParts parts_beside_the_first(const Mesh& mesh, Index fixed = 0) {
    const std::vector<char> is_fixed = flags(mesh.vertex_count(), {fixed});
    return {mesh.vertices,
            mesh.faces,
            find_components(mesh.vertices, mesh.faces, is_fixed, Execution()),
            FollowKind::kRigid,
            InstructionSet::kPortable,
            1,
            Execution()};
}

/// How far it is from rigid: the largest change of a distance within it.
double largest_stretch(const Positions& before, const Positions& after) {
    double most = 0.0;
    for (Index a = 0; a < before.rows(); ++a) {
        for (Index b = 0; b < a; ++b) {
            const double change = (after.row(a) - after.row(b)).norm() / (before.row(a) - before.row(b)).norm() - 1.0;
            most = std::max(most, std::abs(change));
        }
    }
    return most;
}

TEST(LooseParts, ATurnedHeadTakesItsEyesAlong) {
    const Head head;
    const Positions result = solved(head.binding(LooseRule::kFollow), head.turned(1.05));
    for (Index number = 0; number < 4; ++number) {
        const Positions before = head.part(head.mesh.vertices, number);
        const Positions after = head.part(result, number);
        EXPECT_LT(largest_stretch(before, after), 0.05);
        // As far from the skin as it was: its nearest vertex of the head is still its nearest but for a little.
        const Vector3 centre = before.colwise().mean();
        const Vector3 centre_after = after.colwise().mean();
        Index nearest = 0;
        (head.mesh.vertices.topRows(head.head_count).rowwise() - centre.transpose())
            .rowwise()
            .squaredNorm()
            .minCoeff(&nearest);
        EXPECT_NEAR((Vector3(result.row(nearest)) - centre_after).norm(),
                    (Vector3(head.mesh.vertices.row(nearest)) - centre).norm(), 0.04);  // a fifth of its radius
        EXPECT_GT((centre_after - centre).norm(), 0.3);
    }
}

TEST(LooseParts, WhatIsInsideAnotherKeepsItsPlaceInIt) {
    const Head head;
    const Positions result = solved(head.binding(LooseRule::kFollow), head.turned(1.05));
    for (Index eye = 0; eye < 4; eye += 2) {
        const auto both = [&](const Positions& of) {
            Positions rows(2 * head.eye_count, 3);
            rows << head.part(of, eye), head.part(of, eye + 1);
            return rows;
        };
        // One similarity for both: all distances change by one factor.
        const Positions before = both(head.mesh.vertices);
        const Positions after = both(result);
        const double factor = (after.row(0) - after.row(1)).norm() / (before.row(0) - before.row(1)).norm();
        for (Index v = 1; v < before.rows(); ++v) {
            EXPECT_NEAR((after.row(0) - after.row(v)).norm(), factor * (before.row(0) - before.row(v)).norm(), 1e-12);
        }
    }
}

TEST(LooseParts, ASimilarityTakesThemAlong) {
    const Head head;
    const Positions whole = moved_by_similarity(head.mesh.vertices, 1.7, {1.0, 2.0, -0.5}, 2.4, {3.0, -1.0, 0.5});
    Binding binding = head.binding(LooseRule::kFollow);
    binding.rigidity = 0.0;  // lengths do not count
    EXPECT_LT(largest_distance(solved(binding, rows_of(whole, head.anchors)), whole), 1e-6);
    Positions after = whole;
    after.bottomRows(4 * head.eye_count).setZero();
    parts_beside_the_first(head.mesh).carry(head.mesh.vertices, after.data(), 1, Execution());
    EXPECT_LT(largest_distance(after, whole), 1e-10);
}

TEST(LooseParts, OfTwoHeldPartsTheNearerOneCarries) {
    const Mesh button = moved(sphere(1), 0.05, {10.0, 0.0, 1.02});
    const Mesh mesh = joined(joined(sphere(2), moved(sphere(2), 1.0, {10.0, 0.0, 0.0})), button);
    const Index count = sphere(2).vertex_count();
    Binding binding{mesh.vertices, mesh.faces, {0, 1, 2, 3, count, count + 1, count + 2, count + 3}};
    binding.loose = LooseRule::kFollow;
    Positions targets = rows_of(mesh.vertices, binding.anchors);
    targets.bottomRows(4).col(1).array() += 2.5;
    const Positions result = solved(binding, targets);
    for (Index v = 2 * count; v < mesh.vertex_count(); ++v)
        EXPECT_NEAR(result(v, 1), mesh.vertices(v, 1) + 2.5, 1e-3);
}

TEST(LooseParts, TheRestOfTheMeshHasTheSameBitsAndStayingPartsAreAtRest) {
    const Head head;
    const auto following = bound(head.binding(LooseRule::kFollow));
    const auto staying = bound(head.binding(LooseRule::kStay));
    EXPECT_EQ(following->report().carriers, (std::vector<Index>{-1, 0, 0, 0, 0}));
    EXPECT_EQ(staying->report().carriers, (std::vector<Index>{-1, -1, -1, -1, -1}));
    const Positions follow = solve(*following, head.turned(1.05)).vertices;
    const Positions stay = solve(*staying, head.turned(1.05)).vertices;
    EXPECT_EQ(follow.topRows(head.head_count), stay.topRows(head.head_count));
    const Positions later = solve_from(*staying, head.turned(1.0), follow).vertices;
    EXPECT_EQ(later.bottomRows(4 * head.eye_count), head.mesh.vertices.bottomRows(4 * head.eye_count));
}

TEST(LooseParts, TheirPlaceIsThatOfTheShapeAloneWhateverWasBeforeAndForAnyNumberOfThreads) {
    const Head head;
    Binding binding = head.binding(LooseRule::kFollow);
    binding.threads = 1;
    const auto deformer = bound(binding);
    const Positions first = solve(*deformer, head.turned(0.4)).vertices;
    Positions other = first;
    other.bottomRows(4 * head.eye_count).array() += 0.3;  // of the loose parts alone
    const Positions expected = solve_from(*deformer, head.turned(0.5), first).vertices;
    EXPECT_EQ(solve_from(*deformer, head.turned(0.5), other).vertices, expected);
    binding.threads = 4;
    EXPECT_EQ(solve_from(*bound(binding), head.turned(0.5), first).vertices, expected);
}

TEST(LooseParts, FramesOfAClipCarryThemAsSingleSolvesDo) {
    const Head head;
    Execution execution;
    Deformer deformer(head.binding(LooseRule::kFollow), execution);
    constexpr Index kFrames = 9;
    const auto anchors = static_cast<Index>(head.anchors.size());
    std::vector<double> targets;
    for (Index frame = 0; frame < kFrames; ++frame) {
        const Positions at = head.turned(frame == 5 ? 0.9 : 0.1 * frame);  // with a jump to be spread
        targets.insert(targets.end(), at.data(), at.data() + at.size());
    }
    SequenceOptions options;
    options.chunk = 4;
    options.overlap = 3;
    const Trajectories trajectories{kFrames, anchors, targets, {}};
    const Sequence clip = solve_sequence(deformer, trajectories, options, execution);
    for (Index frame = 0; frame < kFrames; ++frame) {
        std::vector<float> shape(
            clip.vertices.get() + static_cast<std::ptrdiff_t>(frame) * clip.vertex_count * 3,
            clip.vertices.get() + static_cast<std::ptrdiff_t>(frame + 1) * clip.vertex_count * 3);
        const std::vector<float> before = shape;
        deformer.bound().loose_parts().carry(head.mesh.vertices, shape.data(), 1, execution);
        EXPECT_EQ(shape, before);
    }
}

/// A flat disc of 13 vertices a little above the plane z = 0.
Mesh button(double radius, double x, double y) {
    Mesh mesh;
    mesh.vertices.resize(13, 3);
    mesh.faces.resize(12, 3);
    mesh.vertices.row(12) << x, y, 0.02;
    for (Index k = 0; k < 12; ++k) {
        const double angle_rad = k * std::acos(-1.0) / 6.0;
        mesh.vertices.row(k) << x + radius * std::cos(angle_rad), y + radius * std::sin(angle_rad), 0.02;
        mesh.faces.row(k) << 12, k, (k + 1) % 12;
    }
    return mesh;
}

/// Where (x, y) of a flat grid has gone in z, between the vertices as its triangles have it.
double lift_of_grid(const Positions& moved, Index columns, double x, double y) {
    const auto c = static_cast<Index>(x);
    const auto r = static_cast<Index>(y);
    const double u = x - c;
    const double w = y - r;
    const auto lift = [&](Index column, Index row) { return moved(row * columns + column, 2); };
    const double both = lift(c, r) + std::min(u, w) * (lift(c + 1, r + 1) - lift(c, r));
    return u > w ? both + (u - w) * (lift(c + 1, r) - lift(c, r)) : both + (w - u) * (lift(c, r + 1) - lift(c, r));
}

TEST(LooseParts, AButtonGoesAsFarAsTheSurfaceThatItTouches) {
    constexpr Index kColumns = 31;
    const Mesh plane = grid(kColumns, kColumns, 0.0);
    for (const double radius : {0.0, 0.2, 0.6, 1.5}) {
        for (const auto& [x, y] : {std::pair(15.0, 15.0), {15.5, 15.5}, {17.0, 15.0}, {17.5, 15.0}, {16.4, 17.2}}) {
            const Mesh mesh = joined(plane, button(radius, x, y));
            Positions after = mesh.vertices;
            for (Index v = 0; v < plane.vertex_count(); ++v)
                after(v, 2) = 4.0 * std::exp(-(after.row(v) - Eigen::RowVector3d(15, 15, 0)).squaredNorm() / 8.0);
            parts_beside_the_first(mesh).carry(mesh.vertices, after.data(), 1, Execution());
            double surface = 0.0;
            for (Index v = plane.vertex_count(); v < mesh.vertex_count(); ++v)
                surface += lift_of_grid(after, kColumns, mesh.vertices(v, 0), mesh.vertices(v, 1)) / 13.0;
            const double lift = after.bottomRows(13).col(2).mean();
            EXPECT_NEAR(lift / surface, 1.0, 0.02) << "radius " << radius << " at " << x << ", " << y;
        }
    }
}

/// The vertices and faces of a mesh in another order: vertex v becomes order[v].
Mesh in_order(const Mesh& mesh, const std::vector<Index>& order) {
    Mesh result = mesh;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        result.vertices.row(order[v]) = mesh.vertices.row(v);
    for (Index f = 0; f < mesh.faces.rows(); ++f) {
        for (int c = 0; c < 3; ++c)
            result.faces(mesh.faces.rows() - 1 - f, c) = order[mesh.faces(f, (c + 1) % 3)];
    }
    return result;
}

TEST(LooseParts, TheOrderOfVerticesAndFacesHardlyMatters) {
    // A large ball and a small one, whose patch is widened.
    const Mesh balls = joined(moved(sphere(1), 0.7, {6.4, 7.1, 5.5}), moved(sphere(1), 0.1, {4.4, 9.3, 4.3}));
    const Mesh mesh = joined(with_noise(grid(15, 15, 0.1), 0.2, 3), balls);
    std::vector<Index> order(mesh.vertex_count());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(5));
    const Mesh other = in_order(mesh, order);
    const auto carried = [&](const Mesh& of, const std::vector<Index>& place) {
        Positions after = of.vertices;
        for (Index v = 0; v < after.rows(); ++v)
            after.row(v) += Eigen::RowVector3d(std::sin(after(v, 1)), 0.3 * after(v, 2), std::cos(after(v, 0)));
        parts_beside_the_first(of, place[0]).carry(of.vertices, after.data(), 1, Execution());
        return rows_of(after, place);
    };
    std::vector<Index> same(order.size());
    std::iota(same.begin(), same.end(), 0);
    EXPECT_LT(largest_distance(carried(mesh, same), carried(other, order)), 1e-10);
}

/// A turned head, and a soft border of these vertices of loose parts, which stay where they are.
struct Bordered {
    Head head;
    Binding binding = head.binding(LooseRule::kFollow);
    Positions targets;

    explicit Bordered(const std::vector<Index>& border) {
        binding.strengths.assign(head.anchors.size(), std::numeric_limits<double>::infinity());
        binding.strengths.resize(head.anchors.size() + border.size(), 1.0);
        binding.is_border.assign(head.anchors.size(), 0);
        binding.is_border.resize(binding.strengths.size(), 1);
        binding.anchors.insert(binding.anchors.end(), border.begin(), border.end());
        targets = rows_of(head.mesh.vertices, binding.anchors);
        targets.topRows(static_cast<Index>(head.anchors.size())) = head.turned(1.05);
    }
};

TEST(LooseParts, ASoftBorderAloneHoldsNoPart) {
    std::vector<Index> loose(static_cast<std::size_t>(4 * Head().eye_count));
    std::iota(loose.begin(), loose.end(), Head().head_count);
    const Bordered bordered(loose);
    EXPECT_EQ(solved(bordered.binding, bordered.targets),
              solved(bordered.head.binding(LooseRule::kFollow), bordered.head.turned(1.05)));
    // Without anything that holds, all stays at rest.
    const Mesh ball = sphere(1);
    Binding binding{ball.vertices, ball.faces, {0, 1, 2}};
    binding.strengths = {1.0, 1.0, 1.0};
    binding.is_border = {1, 1, 1};
    binding.loose = LooseRule::kFollow;
    const Positions targets = ball.vertices.topRows(3).array() + 0.5;
    EXPECT_EQ(solved(binding, targets), ball.vertices);
    EXPECT_EQ(solved(binding, targets, PositionsView(ball.vertices)), ball.vertices);
}

TEST(LooseParts, ASoftBorderOfWhatIsCarriedMayBeFreed) {
    const Bordered bordered({Head().head_count});
    const auto deformer = bound(bordered.binding);
    SolveOptions options;
    options.weights.assign(bordered.binding.anchors.size(), 1.0);
    const Positions all = solve(*deformer, bordered.targets, options).vertices;
    options.weights.back() = 0.0;
    EXPECT_EQ(solve(*deformer, bordered.targets, options).vertices, all);
    options.weights.front() = 0.0;  // of one that is met exactly
    EXPECT_THROW(solve(*deformer, bordered.targets, options), InvalidInput);
}

TEST(LooseParts, ThinPatchesAndLooseVerticesGiveFiniteShapes) {
    // One triangle carries; what it carries: a vertex without faces, a segment's ends, a copy of itself.
    Positions vertices(9, 3);
    vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.3, 0.3, 0.1, 0.3, 0.3, 0.1, 5, 5, 5, 0, 0, 0, 1, 0, 0, 0, 1, 0;
    Triangles faces(2, 3);
    faces << 0, 1, 2, 6, 7, 8;
    Binding binding{vertices, faces, {0, 1, 2}};
    binding.loose = LooseRule::kFollow;
    const Positions whole = moved_by_similarity(vertices, 2.0, Vector3::UnitX(), 1.0, {1.0, 2.0, 3.0});
    EXPECT_LT(largest_distance(solved(binding, whole.topRows(3)), whole), 1e-9);
    // A carrier of which but one vertex is held, and all in one place.
    const Mesh ball = joined(sphere(1), moved(sphere(1), 0.0, {2.0, 0.0, 0.0}));
    Binding lone{ball.vertices, ball.faces, {0}};
    lone.loose = LooseRule::kFollow;
    Positions target = ball.vertices.topRows(1);
    target.row(0) += Eigen::RowVector3d(1.0, 0.0, 0.0);
    EXPECT_TRUE(solved(lone, target).allFinite());
}

/// An arm that bends, in a sleeve with a button.
struct DressedArm {
    Mesh arm = capped_tube(24, 40, 10.0);
    Mesh worn =
        joined(moved(capped_tube(20, 24, 6.0), 1.0, {0.0, 0.0, 2.0}), moved(sphere(1), 0.06, {1.2, 0.0, 4.0}));
    Mesh mesh;
    Binding binding{Positions(0, 3), Triangles(0, 3), std::vector<Index>()};

    DressedArm() {
        const Index cloth_count = worn.vertex_count() - sphere(1).vertex_count();
        worn.vertices.topRows(cloth_count).leftCols(2) *= 1.1;
        mesh = joined(arm, worn);
        std::vector<Index> anchors;
        for (Index v = 0; v < arm.vertex_count(); ++v) {
            if (arm.vertices(v, 2) < 2.0 || arm.vertices(v, 2) > 8.0) anchors.push_back(v);
        }
        binding = Binding(mesh.vertices, mesh.faces, anchors);
        binding.loose = LooseRule::kFollow;
        binding.threads = 1;
    }

    Positions bent(double angle_rad) const {
        Positions targets = rows_of(mesh.vertices, binding.anchors);
        const Eigen::AngleAxisd turn(angle_rad, Vector3::UnitY());
        const Vector3 centre(0.0, 0.0, 5.0);
        for (Index k = 0; k < targets.rows(); ++k) {
            if (targets(k, 2) > 5.0)
                targets.row(k) = (centre + turn * (Vector3(targets.row(k)) - centre)).transpose();
        }
        return targets;
    }
};

TEST(LooseParts, AShirtInTheBodysMeshBendsAsAFollowerDoes) {
    const DressedArm dressed;
    const auto deformer = bound(dressed.binding);
    EXPECT_EQ(deformer->report().carriers, (std::vector<Index>{-1, 0, 1}));  // the button by the sleeve
    FollowBinding binding(dressed.arm.vertices, dressed.arm.faces, dressed.worn.vertices, dressed.worn.faces);
    const Follower follower(binding);
    EXPECT_EQ(follower.kinds(), (std::vector<FollowKind>{FollowKind::kCloth, FollowKind::kRigid}));
    const Index count = dressed.arm.vertex_count();
    const auto expect_followed = [&](const Positions& result) {
        const Positions worn = result.bottomRows(dressed.worn.vertex_count());
        EXPECT_LT(largest_distance(worn, follower.follow(result.topRows(count))), 1e-9);
        EXPECT_GT(largest_stretch(dressed.worn.vertices, worn), 0.05);  // not stiff
    };
    const Positions result = solve(*deformer, dressed.bent(1.2)).vertices;
    expect_followed(result);
    Deformer::Drag drag(*deformer);
    for (const double angle_rad : {0.3, 0.4, 0.5, 0.6})
        expect_followed(solve_next(drag, dressed.bent(angle_rad)).vertices);
    const std::optional<Positions> draft = drag.draft(dressed.bent(0.65));
    ASSERT_TRUE(draft);
    expect_followed(*draft);
    // Bound again with another anchor, it follows with the same bits of the same surface.
    Binding again = deformer->binding_again();
    again.anchors = dressed.binding.anchors;
    again.anchors.pop_back();
    expect_followed(solve(*bound(again, deformer.get()), dressed.bent(1.2).topRows(again.anchors.size())).vertices);
}

TEST(LooseParts, BindingAgainFindsOtherCarriers) {
    const Head head;
    const auto deformer = bound(head.binding(LooseRule::kFollow));
    Binding again = deformer->binding_again();
    again.anchors = head.anchors;
    again.anchors.push_back(head.head_count);  // of the first eye
    EXPECT_EQ(bound(again, deformer.get())->report().carriers,
              (std::vector<Index>{-1, -1, 1, 0, 0}));  // the first iris by its eye
}

TEST(LooseParts, CanBeCancelledWhileTheyAreFound) {
    const Head head;
    const auto stages =
        cancelled_everywhere([&](Execution& execution) { Deformer(head.binding(LooseRule::kFollow), execution); });
    EXPECT_FALSE(stages.empty());
}

}  // namespace
}  // namespace meanvalue::tests
