// Anchors at points inside faces.
#include <cmath>
#include <limits>

#include "meanvalue/sequence/sequence.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

constexpr double kMet = 1e-6;  // of the size

/// `count` points in faces that share no vertex, far from each other, at weights between those of a corner and a
/// center.
std::vector<FacePoint> spread_points(const Mesh& mesh, Index count) {
    std::vector<FacePoint> points;
    std::vector<char> is_taken(mesh.vertex_count(), 0);
    for (const Index v : spread_vertices(mesh, 2 * count)) {
        for (Index f = 0; f < mesh.faces.rows() && static_cast<Index>(points.size()) < count; ++f) {
            const auto face = mesh.faces.row(f);
            if ((face.array() != v).all() || is_taken[face[0]] || is_taken[face[1]] || is_taken[face[2]]) continue;
            for (int c = 0; c < 3; ++c)
                is_taken[face[c]] = 1;
            const double most = 1.0 - 2.0 / 3.0 * static_cast<double>(points.size()) / count;
            points.push_back({f, {most, 0.7 * (1.0 - most), 0.3 * (1.0 - most)}});
            break;
        }
    }
    return points;
}

Positions places(const Mesh& mesh, const std::vector<FacePoint>& points, const Positions& vertices) {
    Positions result(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t p = 0; p < points.size(); ++p) {
        const auto face = mesh.faces.row(points[p].face);
        result.row(p).setZero();
        for (int c = 0; c < 3; ++c)
            result.row(p) += points[p].weights[c] * vertices.row(face[c]);
    }
    return result;
}

/// A bend, told by points alone.
struct Bent {
    Mesh mesh;
    std::vector<FacePoint> points;
    Positions bent;

    explicit Bent(const Mesh& mesh, Index count = 12) : mesh(mesh), points(spread_points(mesh, count)) {
        bent = mesh.vertices;
        const double length = mesh.vertices.col(2).maxCoeff();
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const double angle = 1.2 * mesh.vertices(v, 2) / length;
            const double radius = length / 1.2 + mesh.vertices(v, 1);
            bent.row(v) << mesh.vertices(v, 0), radius * std::cos(angle) - length / 1.2, radius * std::sin(angle);
        }
    }
    Binding binding() const {
        Binding binding = binding_of(mesh, {}, Method::kFast, 1);
        binding.points = points;
        return binding;
    }
    Positions targets(double share = 1.0) const {
        return places(mesh, points, mesh.vertices + share * (bent - mesh.vertices));
    }
    double missed(const Positions& pose, double share = 1.0) const {
        return largest_distance(places(mesh, points, pose), targets(share)) / mesh.diagonal();
    }
};

class PointsOf : public testing::TestWithParam<Mesh> {};

TEST_P(PointsOf, AreMet) {
    const Bent bent(GetParam());
    const Deformer deformer(bent.binding());
    EXPECT_EQ(deformer.report().anchor_count, 12);
    EXPECT_EQ(deformer.report().components.front().undetermined, 0);
    const Solution solution = solve(deformer, bent.targets());
    EXPECT_TRUE(solution.converged);
    EXPECT_LT(bent.missed(solution.vertices), kMet);
    EXPECT_LT(largest_distance(solution.vertices, bent.bent), 0.05 * bent.mesh.diagonal());
    // As well where the pull is hard.
    const Positions torn = 2.0 * bent.targets();
    EXPECT_LT(largest_distance(places(bent.mesh, bent.points, solve(deformer, torn).vertices), torn),
              kMet * bent.mesh.diagonal());
}

TEST_P(PointsOf, TurnWithTheWhole) {
    const Bent bent(GetParam());
    const auto move = [](const Positions& of) { return moved_by_similarity(of, 1.0, {1, 2, 3}, 2.0, {5, -2, 1}); };
    const Positions pose = solve(Deformer(bent.binding()), move(bent.targets(0.0))).vertices;
    EXPECT_LT(largest_distance(pose, move(bent.mesh.vertices)), 1e-4 * bent.mesh.diagonal());
}

TEST_P(PointsOf, DragsClipsAndExamplesMeetThemAndEndWhereASolveDoes) {
    const Bent bent(GetParam());
    for (const bool has_example : {false, true}) {
        Binding binding = bent.binding();
        if (has_example) binding.examples = {share(bent.bent, "example")};
        const Deformer deformer(binding);
        const Positions expected = solve(deformer, bent.targets()).vertices;
        EXPECT_LT(bent.missed(expected), kMet);
        Deformer::Drag drag(deformer);
        Trajectories clip{13, 12, {}, {}};
        Positions last;
        for (int frame = 0; frame < 13; ++frame) {
            const double share = frame / 12.0;
            const Positions targets = bent.targets(share);
            clip.targets.insert(clip.targets.end(), targets.data(), targets.data() + targets.size());
            const Positions pose = solve_next(drag, targets).vertices;
            EXPECT_LT(bent.missed(pose, share), kMet) << frame;
            last = pose;
        }
        EXPECT_LT(largest_distance(last, expected), 5e-3 * bent.mesh.diagonal());
        EXPECT_TRUE(drag.draft(bent.targets(1.02)).has_value());
        const Sequence frames = solve_sequence(deformer, clip);
        const Positions end =
            Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(
                frames.vertices.get() + 12 * 3 * bent.mesh.vertex_count(), bent.mesh.vertex_count(), 3)
                .cast<double>();
        EXPECT_LT(bent.missed(end), kMet);
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, PointsOf,
                         testing::Values(capped_tube(16, 25, 8.0), with_noise(capped_tube(24, 120, 12.0), 0.1, 2)));

TEST(Points, AtACornerAreAnchorsOfThatVertex) {
    const Mesh mesh = capped_tube(16, 25, 8.0);
    Bent bent(mesh);
    Binding of_vertices = binding_of(mesh, {}, Method::kFast, 1);
    for (FacePoint& point : bent.points) {
        point.weights = {0.0, 1.0, 0.0};
        of_vertices.anchors.push_back(mesh.faces(point.face, 1));
    }
    for (const double strength : {std::numeric_limits<double>::infinity(), 0.5}) {
        Binding of_points = bent.binding();
        of_points.strengths = of_vertices.strengths = std::vector<double>(12, strength);
        EXPECT_LT(largest_distance(solve(Deformer(of_points), bent.targets()).vertices,
                                   solve(Deformer(of_vertices), bent.targets()).vertices),
                  2e-3 * mesh.diagonal())
            << strength;
    }
}

TEST(Points, SoftOnesGiveWayAndWeightsFreeThem) {
    const Bent bent(capped_tube(16, 25, 8.0));
    Binding binding = bent.binding();
    double last = 1.0;
    for (const double strength : {1e-2, 1.0, 1e2}) {
        binding.strengths.assign(12, strength);
        const double missed = bent.missed(solve(Deformer(binding), bent.targets()).vertices);
        EXPECT_LT(missed, 0.5 * last) << strength;
        last = missed;
    }
    binding.strengths.clear();
    const Deformer deformer(binding);
    SolveOptions options;
    options.weights.assign(12, 1.0);
    options.weights[5] = 0.0;
    Positions targets = bent.targets();
    targets.row(5).setConstant(std::nan(""));
    const Positions pose = solve(deformer, targets, options).vertices;
    binding.points.erase(binding.points.begin() + 5);
    targets = bent.targets()({0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11}, Eigen::all);
    EXPECT_LT(largest_distance(pose, solve(Deformer(binding), targets).vertices), 2e-3 * bent.mesh.diagonal());
}

TEST(Points, StandBehindVerticesAndThreadsDoNotMatter) {
    const Bent bent(with_noise(capped_tube(24, 120, 12.0), 0.1, 2));
    Binding binding = bent.binding();
    for (Index v = 0; v < bent.mesh.vertex_count(); ++v) {
        if (bent.mesh.vertices(v, 2) < 0.3) binding.anchors.push_back(v);
    }
    binding.points.clear();
    for (const FacePoint& point : bent.points) {
        if (bent.mesh.vertices(bent.mesh.faces(point.face, 0), 2) > 1.0) binding.points.push_back(point);
    }
    const Positions of_points = places(bent.mesh, binding.points, bent.bent);
    Positions targets(static_cast<Eigen::Index>(binding.anchors.size()) + of_points.rows(), 3);
    targets << rows_of(bent.bent, binding.anchors), of_points;
    const Positions pose = solve(Deformer(binding), targets).vertices;
    EXPECT_EQ(rows_of(pose, binding.anchors), rows_of(bent.bent, binding.anchors));
    EXPECT_LT(largest_distance(places(bent.mesh, binding.points, pose), of_points), kMet * bent.mesh.diagonal());
    binding.threads = 4;
    EXPECT_EQ(solve(Deformer(binding), targets).vertices, pose);
}

TEST(Points, WhatIsWrongIsNamed) {
    const Bent bent(capped_tube(16, 25, 8.0));
    const auto told = [&](const auto& spoil) {
        Binding binding = bent.binding();
        spoil(binding);
        return message_of<InvalidInput>([&] { bound(binding); });
    };
    EXPECT_TRUE(contains(told([](Binding& b) { b.points[2].face = 9999; }), "points[2] is in face 9999, but"));
    for (const Vector3& weights : {Vector3(0.5, 0.5, 0.5), Vector3(-0.5, 1.0, 0.5), Vector3(std::nan(""), 1.0, 0.0)})
        EXPECT_TRUE(contains(told([&](Binding& b) { b.points[1].weights = weights; }), "that sum to 1"));
    EXPECT_TRUE(contains(told([&](Binding& b) { b.anchors = {bent.mesh.faces(b.points[0].face, 1)}; }),
                         "is an anchor that is met exactly; choose a face"));
    EXPECT_TRUE(contains(told([](Binding& b) {
                             b.points.resize(4, b.points[0]);
                             b.points[1] = b.points[2] = b.points[3] = b.points[0];
                         }),
                         "points[3] is in face"));
    EXPECT_TRUE(contains(told([](Binding& b) { b.method = Method::kFull; }), "only method 'fast' has points"));
    EXPECT_TRUE(contains(told([](Binding& b) { b.strengths = {1.0}; }), "but there are 12 anchors"));
}

}  // namespace
}  // namespace meanvalue::tests
