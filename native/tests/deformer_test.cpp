#include "meanvalue/deform/deformer.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/morph/morpher.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

TEST(Deformer, ATwistConvergesInTheOrderOfThePapersNineIterations) {
    const Pose twist = two_ends("twist", capped_tube(16, 25, 8.0), Vector3::UnitZ(), kPi / 2, {0, 0, 0});
    const auto deformer = bound(binding_of(twist.mesh, twist.anchors, Method::kFull));
    const Solution solution = solve(*deformer, twist.targets);
    EXPECT_TRUE(solution.converged) << solution.stop_reason;
    EXPECT_LE(solution.iterations, 20);
    EXPECT_GT(solution.energy, 0.0);
    EXPECT_LT(solution.gradient, 1e-3 * solution.initial_gradient);
    expect_energy_never_rises(solution);
    const Solution warm = solve_from(*deformer, twist.targets, solution.vertices);
    EXPECT_LT(warm.iterations, solution.iterations);
    EXPECT_LT(largest_distance(warm.vertices, solution.vertices), 1e-4 * twist.mesh.diagonal());
}

TEST(Deformer, APulledAnchorMakesNoSpike) {
    // The anchors' own rows are in the energy: without them the anchor would leave its ring behind.
    for (const auto& [method, width] : {std::pair(Method::kFull, 21), {Method::kFast, 21}, {Method::kFast, 81}}) {
        const Mesh mesh = grid(width, width, 0.0);
        const Index middle = mesh.vertex_count() / 2;
        Binding binding = binding_of(mesh, {middle}, method, 1, 0.0);
        binding.roi = inside_grid(width, width, 1);
        const auto deformer = bound(binding);
        EXPECT_EQ(deformer->report().level_sizes.size(), width == 81 ? 2u : 1u);  // the largest has a coarse level
        Positions target = mesh.vertices.row(middle);
        target(0, 2) += 0.2 * width;
        const Positions shape = solve(*deformer, target).vertices;
        const double ring_height = (shape(middle - 1, 2) + shape(middle + 1, 2)) / 2;
        EXPECT_LT(0.2 * width - ring_height, 0.25);  // a cone would drop by 0.4
    }
}

TEST(Deformer, AndItsDragsAreMoved) {
    const Pose twist = two_ends("twist", capped_tube(8, 12, 4.0), Vector3::UnitZ(), kPi / 4, {0, 0, 0});
    const Binding binding = binding_of(twist.mesh, twist.anchors, Method::kFast);
    std::vector<Deformer> deformers;
    std::vector<Deformer::Drag> drags;
    for (int k = 0; k < 5; ++k) {
        deformers.emplace_back(binding);
        drags.emplace_back(deformers.back());
    }
    const Positions expected = deformers.front().solve(twist.targets).vertices;
    EXPECT_EQ(deformers.back().solve(twist.targets).vertices, expected);
    deformers.front() = std::move(deformers.back());
    EXPECT_EQ(deformers.front().solve(twist.targets).vertices, expected);
    deformers.clear();  // a drag keeps what was bound
    for (Deformer::Drag& drag : drags)
        EXPECT_EQ(drag.solve(twist.targets).vertices, expected);  // the first solve of each, from rest
    EXPECT_EQ(deform(twist.mesh.vertices, twist.mesh.faces, twist.anchors, twist.targets).vertices, expected);
    const Eigen::VectorXi anchors =
        Eigen::Map<const Eigen::VectorXi>(twist.anchors.data(), static_cast<Eigen::Index>(twist.anchors.size()));
    EXPECT_EQ(Binding(twist.mesh.vertices, twist.mesh.faces, anchors).anchors, twist.anchors);
}

TEST(Deformer, ASolveDoesNotWaitForAnother) {
    const Pose pose = spread_pull("pull", with_noise(torus(80, 60), 0.05, 1), 8, {0.5, 0.5, 1.0});
    const auto deformer = bound(binding_of(pose.mesh, pose.anchors, Method::kFull));
    Execution first;
    std::atomic<bool> first_ended{false};
    std::thread solving([&] {
        SolveOptions endless;
        endless.tolerance = 1e-300;
        endless.max_iterations = 1000000;
        try {
            while (true)
                deformer->solve(pose.targets, {}, endless, first);
        } catch (const Cancelled&) {
        }
        first_ended = true;
    });
    while (std::string(first.stage()) != "solve")
        std::this_thread::yield();
    EXPECT_NO_THROW(solve(*deformer, rows_of(pose.mesh.vertices, pose.anchors)));
    EXPECT_FALSE(first_ended);
    first.cancel();
    solving.join();
}

TEST(Deformer, RefusesBadInputByName) {
    const auto refusal = [](const auto& action) { return message_of<InvalidInput>(action); };
    const Mesh mesh = sphere(1);
    EXPECT_TRUE(contains(refusal([&] { bound_to(mesh, {0, 99}); }), "anchor 1 is vertex 99"));
    EXPECT_TRUE(contains(refusal([&] { bound_to(mesh, {3, 0, 3}); }), "anchors 0 and 2 are both vertex 3"));
    EXPECT_TRUE(contains(refusal([&] { bound_to(mesh, {0}, {}, 1, std::vector<char>(5, 1)); }), "roi has 5"));
    Mesh bad = mesh;
    bad.vertices(7, 0) = std::nan("");
    EXPECT_TRUE(contains(refusal([&] { bound_to(bad, {0}); }), "vertices[7]"));
    for (const double scale : {1e-90, 1e90}) {  // beyond the range of doubles
        bad.vertices = scale * mesh.vertices;
        EXPECT_TRUE(contains(refusal([&] { bound_to(bad, {0}); }), "vertices span"));
    }
    const auto deformer = bound_to(mesh, {0, 1, 2});
    Positions targets = rows_of(mesh.vertices, {0, 1, 2});
    EXPECT_THROW(solve(*deformer, targets.topRows(2)), InvalidInput);
    EXPECT_THROW(solve_from(*deformer, targets, targets), InvalidInput);
    EXPECT_THROW(solve(*deformer, targets, {0.0, 10}), InvalidInput);
    EXPECT_THROW(solve(*deformer, targets, {1e-6, -1}), InvalidInput);
    targets(1, 2) = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(contains(refusal([&] { solve(*deformer, targets); }), "targets[1]"));
}

/// As libigl has meshes.
struct ColumnMajor {
    Eigen::MatrixXd vertices;
    Eigen::MatrixXi faces;
    explicit ColumnMajor(const Mesh& mesh) : vertices(mesh.vertices), faces(mesh.faces) {}
};

TEST(Inputs, BindingsOwnWhatTheyWereMadeFromInAnyLayoutAndMayBeCopied) {
    const Mesh mesh = torus(16, 8);
    const std::vector<Index> anchors = {0, 9, 40, 77};
    Positions targets = rows_of(mesh.vertices, anchors);
    targets(0, 2) += 0.3;
    const Solution expected = Deformer(Binding(mesh.vertices, mesh.faces, anchors)).solve(targets);
    std::vector<Binding> bindings;
    {
        const ColumnMajor given(mesh);
        bindings.emplace_back(given.vertices, given.faces, anchors);
        for (int copy = 0; copy < 5; ++copy)
            bindings.push_back(bindings.front());
        EXPECT_EQ(bindings.back().vertices, bindings.front().vertices);  // copied once
    }
    const Binding last = bindings.back();
    bindings.clear();
    const Deformer deformer(last);
    EXPECT_EQ(&deformer.bound().rest(), last.vertices.get());  // and not at bind
    EXPECT_EQ(deformer.solve(Eigen::MatrixXd(targets)).vertices, expected.vertices);
}

TEST(Inputs, MorphBindingsOwnWhatTheyWereMadeFromInAnyLayoutAndMayBeCopied) {
    const Mesh mesh = torus(16, 8);
    const Positions other = moved_by_similarity(mesh.vertices, 1.2, {0, 0, 1}, 0.7, {0, 0, 0});
    const std::vector<Positions> rows = {mesh.vertices, other};
    const Solution expected = Morpher(MorphBinding(rows, mesh.faces)).solve({0.5, 0.5});
    std::vector<MorphBinding> bindings;
    {
        std::vector<Eigen::MatrixXd> shapes = {rows[0], rows[1]};
        bindings.emplace_back(shapes, ColumnMajor(mesh).faces);
        bindings.push_back(bindings.front());
        bindings.front().shapes.push_back(share(Eigen::MatrixXd(other), "other"));
    }
    const Morpher morpher(bindings.back());
    bindings.clear();
    EXPECT_EQ(morpher.solve({0.5, 0.5}).vertices, expected.vertices);
}

TEST(Inputs, OfOtherThanThreeColumnsAreRefusedByName) {
    const Mesh mesh = torus(16, 8);
    const ColumnMajor given(mesh);
    const auto refusal = [](const auto& action) { return message_of<InvalidInput>(action); };
    EXPECT_TRUE(contains(refusal([&] { Binding(Eigen::MatrixXd(given.vertices.leftCols(2)), given.faces, {0}); }),
                         "vertices has 2 columns; give 3"));
    EXPECT_TRUE(contains(refusal([&] { Binding(given.vertices, Eigen::MatrixXi::Zero(5, 4).eval(), {0}); }),
                         "faces has 4 columns; give 3"));
    const Deformer deformer(Binding(given.vertices, given.faces, {0}));
    EXPECT_TRUE(contains(refusal([&] { deformer.solve(Eigen::MatrixXd::Zero(1, 2).eval()); }),
                         "targets has 2 columns; give 3"));
}

TEST(Inputs, ABindingOfAnEqualMeshIsBoundAgainAsThatOfTheEarlierOne) {
    const Mesh mesh = torus(16, 8);
    const Deformer first(binding_of(mesh, {0, 9, 40}));
    Execution execution;
    const Deformer again(binding_of(mesh, {0, 9, 77}), execution, &first);
    EXPECT_EQ(&again.bound().rest(), &first.bound().rest());
}

}  // namespace
}  // namespace meanvalue::tests
