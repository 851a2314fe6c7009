// Stiffness of each vertex: limbs bend at their joints.
#include <algorithm>
#include <cmath>
#include <limits>

#include "meanvalue/sequence/sequence.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

constexpr Index kAround = 16;
constexpr Index kAlong = 61;
constexpr double kBone = 3.0;

/// Two straight bones of a capped tube, stiff but around the joint between them, whose middle is ring kAlong / 2. The
/// base is held, and so is the middle of the other cap.
struct Elbow {
    Mesh mesh = capped_tube(kAround, kAlong, 2.0 * kBone);
    std::vector<double> stiffness;
    std::vector<Index> anchors;

    explicit Elbow(double bend_rad = kPi / 4.0) {
        Index tip = 0;
        mesh.vertices.leftCols(2) *= 0.35;
        const double length = mesh.vertices.col(2).maxCoeff();
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const Vector3 rest = mesh.vertices.row(v);
            const double t = std::clamp(std::abs(rest.z() - 0.5 * length) - 0.35, 0.0, 0.35) / 0.35;
            stiffness.push_back(1.0 + 29.0 * t * t * (3.0 - 2.0 * t));
            if (rest.z() < 0.4) anchors.push_back(v);
            if (rest.z() > length - 1e-9 && rest.head<2>().norm() < 1e-9) tip = v;
            // The joint as an arc of half a unit to each side.
            const double s = rest.z() - 0.5 * length;
            const double angle = std::clamp(s + 0.5, 0.0, 1.0) * bend_rad;
            const double arc = std::min(std::max(s, -0.5), 0.5) + 0.5;
            const double radius = 1.0 / bend_rad;
            Vector3 middle(0.0, radius * (1.0 - std::cos(arc * bend_rad)), radius * std::sin(arc * bend_rad) - 0.5);
            const Vector3 along(0.0, std::sin(angle), std::cos(angle));
            middle += (std::min(s + 0.5, 0.0) + std::max(s - 0.5, 0.0)) * along;
            const Vector3 across(0.0, std::cos(angle), -std::sin(angle));
            mesh.vertices.row(v) = middle + rest.x() * Vector3::UnitX() + rest.y() * across;
        }
        anchors.push_back(tip);
    }

    Binding binding(bool is_stiff = true) const {
        Binding binding = binding_of(mesh, anchors, Method::kFast, 1);
        if (is_stiff) binding.stiffness = stiffness;
        return binding;
    }
    /// The tip goes by `share` of its way to the base.
    Positions targets(double share) const {
        Positions targets = rows_of(mesh.vertices, anchors);
        const Eigen::RowVector3d way = targets.topRows(targets.rows() - 1).colwise().mean() - targets.bottomRows(1);
        targets.bottomRows(1) += share * way;
        return targets;
    }
};

/// From the base to the joint, and from there to the tip, past the bent rings.
struct Bones {
    Vector3 upper;
    Vector3 lower;
    double angle_deg() const { return std::acos(upper.normalized().dot(lower.normalized())) * 180.0 / kPi; }
};

Bones bones_of(const Elbow& elbow, const Positions& pose) {
    const Elbow straight(1e-9);
    const auto middle = [&](double z) {
        Vector3 sum = Vector3::Zero();
        Index count = 0;
        for (Index v = 0; v < elbow.mesh.vertex_count(); ++v) {
            if (std::abs(straight.mesh.vertices(v, 2) - z) > 0.08) continue;
            sum += pose.row(v).transpose();
            ++count;
        }
        return Vector3(sum / count);
    };
    return {middle(-0.9) - middle(-2.5), middle(2.5) - middle(0.9)};
}

TEST(Stiffness, AnElbowBendsAsTwoBonesDo) {
    const Elbow elbow;
    const Bones rest = bones_of(elbow, elbow.mesh.vertices);
    // The law of cosines, of bones that meet where the arc's tangents do.
    const double bone = kBone - 0.5 + std::tan(kPi / 8.0) / (kPi / 4.0);
    const double reach = 0.7 * 2.0 * bone * std::cos(kPi / 8.0);
    const double ideal_deg = 180.0 - std::acos(1.0 - reach * reach / (2.0 * bone * bone)) * 180.0 / kPi;
    double stretch[2] = {};
    double angle_deg[2] = {};
    for (const bool is_stiff : {false, true}) {
        const Bones bent = bones_of(elbow, solve(*bound(elbow.binding(is_stiff)), elbow.targets(0.3)).vertices);
        stretch[is_stiff] = std::max(std::abs(bent.upper.norm() / rest.upper.norm() - 1.0),
                                     std::abs(bent.lower.norm() / rest.lower.norm() - 1.0));
        angle_deg[is_stiff] = bent.angle_deg();
    }
    EXPECT_NEAR(angle_deg[1], ideal_deg, 10.0);
    EXPECT_LT(stretch[1], 0.02);
    EXPECT_GT(stretch[0], 0.04);
}

TEST(Stiffness, OfOneHasTheBitsOfNone) {
    const Elbow elbow;
    for (const double rigidity : {0.0, 0.5, 15.0}) {
        Binding binding = elbow.binding(false);
        binding.rigidity = rigidity;
        binding.strengths.assign(elbow.anchors.size(), std::numeric_limits<double>::infinity());
        binding.strengths.back() = 0.1;
        const Positions without = solve(*bound(binding), elbow.targets(0.3)).vertices;
        binding.stiffness.assign(elbow.mesh.vertex_count(), 1.0);
        EXPECT_EQ(solve(*bound(binding), elbow.targets(0.3)).vertices, without) << rigidity;
    }
}

TEST(Stiffness, AlikeEverywhereIsSoMuchMoreRigidity) {
    const Elbow elbow;
    SolveOptions fine;
    fine.tolerance = 1e-7;
    Binding binding = elbow.binding(false);
    binding.rigidity = 60.0;
    const Solution rigid = solve(*bound(binding), elbow.targets(0.3), fine);
    binding.rigidity = 15.0;
    binding.stiffness.assign(elbow.mesh.vertex_count(), 4.0);
    const Solution stiff = solve(*bound(binding), elbow.targets(0.3), fine);
    EXPECT_NEAR(stiff.energy, rigid.energy, 1e-9 * rigid.energy);
    EXPECT_LT(largest_distance(stiff.vertices, rigid.vertices), 1e-4 * elbow.mesh.diagonal());
}

TEST(Stiffness, TurnsWithTheWhole) {
    const Elbow elbow;
    Elbow moved = elbow;
    const auto move = [](const Positions& of) { return moved_by_similarity(of, 1.0, {1, 2, 3}, 2.0, {5, -2, 1}); };
    moved.mesh.vertices = move(elbow.mesh.vertices);
    const Positions pose = solve(*bound(elbow.binding()), elbow.targets(0.3)).vertices;
    EXPECT_LT(largest_distance(solve(*bound(moved.binding()), moved.targets(0.3)).vertices, move(pose)),
              1e-4 * elbow.mesh.diagonal());
}

TEST(Stiffness, DragsClipsAndExamplesEndWhereASolveDoes) {
    const Elbow elbow;
    const Elbow example(kPi / 2.0);
    for (const bool has_example : {false, true}) {
        Binding binding = elbow.binding();
        if (has_example) binding.examples = {share(example.mesh.vertices, "example")};
        const Deformer deformer(binding);
        SequenceOptions clip_options;
        clip_options.tolerance = 1e-5;
        const Positions expected = solve(deformer, elbow.targets(0.3)).vertices;
        const double near = 3e-3 * elbow.mesh.diagonal();
        Deformer::Drag drag(deformer);
        Trajectories clip{13, static_cast<Index>(elbow.anchors.size()), {}, {}};
        Positions last;
        for (int frame = 0; frame < 13; ++frame) {
            const Positions targets = elbow.targets(0.3 * frame / 12.0);
            clip.targets.insert(clip.targets.end(), targets.data(), targets.data() + targets.size());
            last = solve_next(drag, targets).vertices;
        }
        EXPECT_LT(largest_distance(last, expected), near) << has_example;
        const std::optional<Positions> draft = drag.draft(elbow.targets(0.31));
        ASSERT_TRUE(draft.has_value());
        EXPECT_LT(largest_distance(*draft, solve_next(drag, elbow.targets(0.31)).vertices), near);
        const Sequence frames = solve_sequence(deformer, clip, clip_options);
        const Positions end =
            Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(
                frames.vertices.get() + 12 * 3 * elbow.mesh.vertex_count(), elbow.mesh.vertex_count(), 3)
                .cast<double>();
        EXPECT_LT(largest_distance(end, expected), near) << has_example;
    }
}

TEST(Stiffness, AnotherOneIsBoundAgain) {
    const Elbow elbow;
    const auto earlier = bound(elbow.binding(false));
    Binding again = earlier->binding_again();
    EXPECT_TRUE(again.stiffness.empty());
    again.anchors = elbow.anchors;
    again.stiffness = elbow.stiffness;
    EXPECT_EQ(solve(*bound(again, earlier.get()), elbow.targets(0.3)).vertices,
              solve(*bound(elbow.binding()), elbow.targets(0.3)).vertices);
}

TEST(Stiffness, SoftAnchorsKeepTheirReach) {
    const Elbow elbow;
    for (const double strength : {1e-3, 1e-2}) {
        double reach[2] = {};
        for (const bool is_stiff : {false, true}) {
            Binding binding = elbow.binding(is_stiff);
            binding.strengths.assign(elbow.anchors.size(), std::numeric_limits<double>::infinity());
            binding.strengths.back() = strength;
            const Positions targets = elbow.targets(0.3);
            const Eigen::RowVector3d from = elbow.mesh.vertices.row(elbow.anchors.back());
            const Eigen::RowVector3d way = targets.bottomRows(1) - from;
            const Positions pose = solve(*bound(binding), targets).vertices;
            reach[is_stiff] = (pose.row(elbow.anchors.back()) - from).dot(way) / way.squaredNorm();
        }
        EXPECT_GT(reach[0], 0.2);
        EXPECT_NEAR(reach[1], reach[0], 0.1) << strength;
    }
}

TEST(Stiffness, WhatIsWrongIsNamed) {
    const Elbow elbow;
    const auto told = [&](Index v, double factor) {
        Binding binding = elbow.binding();
        binding.stiffness[v] = factor;
        return message_of<InvalidInput>([&] { bound(binding); });
    };
    for (const double factor : {0.0, -1.0, 2e6, std::numeric_limits<double>::infinity(), std::nan("")})
        EXPECT_TRUE(contains(told(5, factor), "stiffness[5] is ")) << factor;
    Binding binding = elbow.binding();
    binding.stiffness.pop_back();
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { bound(binding); }), "vertices; give one number for each"));
    binding = elbow.binding();
    binding.method = Method::kFull;
    EXPECT_TRUE(contains(message_of<InvalidInput>([&] { bound(binding); }), "only method 'fast' has a stiffness"));
}

}  // namespace
}  // namespace meanvalue::tests
