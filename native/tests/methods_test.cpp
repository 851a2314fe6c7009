// What every method promises, whatever becomes of the shape between its anchors.
#include <array>
#include <tuple>

#include "meanvalue/deform/deformer.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr Method kMethods[] = {Method::kFast, Method::kPaper, Method::kFull};

/// Without rigidity, so that a shape of another size is as good.
std::unique_ptr<Deformer> bound_to(const Mesh& mesh, const std::vector<Index>& anchors, Method method) {
    return bound(binding_of(mesh, anchors, method, 1, 0.0));
}

/// How near a solve comes to a shape whose energy is zero, as a share of the diagonal.
double exactness_of(Method method) {
    return method == Method::kFull ? 1e-6 : 1e-9;
}

/// With a coarse level where the method is fast.
Mesh mesh_for(Method method) {
    return method == Method::kFast ? capped_tube(40, 60, 8.0) : capped_tube(12, 25, 8.0);
}

/// A pull at one of six anchors.
struct Pulled {
    Mesh mesh;
    std::vector<Index> anchors = spread_vertices(mesh, 6);
    Positions targets = rows_of(mesh.vertices, anchors);

    explicit Pulled(const Mesh& of) : mesh(of) { targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0); }
};

class MethodOnShape : public testing::TestWithParam<std::tuple<Method, Mesh>> {};

TEST_P(MethodOnShape, UnmovedAnchorsGiveTheRestShape) {
    const auto& [method, mesh] = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Solution solution = solve(*bound_to(mesh, anchors, method), rows_of(mesh.vertices, anchors));
    EXPECT_LT(largest_distance(solution.vertices, mesh.vertices), exactness_of(method) * mesh.diagonal());
    EXPECT_TRUE(solution.converged);
}

TEST_P(MethodOnShape, ASimilarityOfTheAnchorsTakesTheShapeAlong) {
    const auto& [method, mesh] = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const auto deformer = bound_to(mesh, anchors, method);
    for (const auto& [angle_deg, scale] : {std::pair(20.0, 0.3), {120.0, 1.7}, {180.0, 0.9}}) {
        const Positions moved =
            moved_by_similarity(mesh.vertices, scale, {1, 2, 3}, angle_deg * kPi / 180, {5, -2, 1});
        const Solution solution = solve(*deformer, rows_of(moved, anchors));
        EXPECT_LT(largest_distance(solution.vertices, moved), exactness_of(method) * mesh.diagonal()) << angle_deg;
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, MethodOnShape,
                         testing::Combine(testing::ValuesIn(kMethods),
                                          testing::Values(sphere(3), with_noise(sphere(3), 0.1, 1),
                                                          grid(20, 18, 0.02), torus(30, 16), capped_tube(16, 12, 6.0),
                                                          bar(4, 16), joined(grid(9, 8, 0.05), grid(8, 9, 0.02)))));
INSTANTIATE_TEST_SUITE_P(LargeShapes, MethodOnShape,
                         testing::Combine(testing::Values(Method::kFast, Method::kPaper),
                                          testing::Values(sphere(5), torus(80, 60))));

class EveryMethod : public testing::TestWithParam<Method> {};

TEST_P(EveryMethod, MeetsItsAnchorsExactlyWithTheSameBitsEachTimeAndForAnyNumberOfThreads) {
    const Pulled pulled(with_noise(torus(80, 60), 0.05, 1));
    const auto one = bound(binding_of(pulled.mesh, pulled.anchors, GetParam(), 1));
    const auto four = bound(binding_of(pulled.mesh, pulled.anchors, GetParam(), 4));
    const Solution first = solve(*one, pulled.targets);
    EXPECT_EQ(rows_of(first.vertices, pulled.anchors), pulled.targets);
    solve(*one, rows_of(pulled.mesh.vertices, pulled.anchors));
    EXPECT_EQ(first.vertices, solve(*one, pulled.targets).vertices);
    EXPECT_EQ(first.vertices, solve(*four, pulled.targets).vertices);
    EXPECT_EQ(first.energies, solve(*four, pulled.targets).energies);
    const Positions further = 1.05 * pulled.targets;
    EXPECT_EQ(solve_from(*one, further, first.vertices).vertices,
              solve_from(*four, further, first.vertices).vertices);
}

TEST_P(EveryMethod, OutsideTheRegionOfInfluenceNothingMoves) {
    const Index width = GetParam() == Method::kFast ? 91 : 41;  // which has a coarse level
    const Mesh mesh = grid(width, width, 0.01);
    const Index middle = width / 2 * width + width / 2;
    Binding binding = binding_of(mesh, {middle}, GetParam());
    binding.roi = inside_grid(width, width, 10);
    const auto deformer = bound(binding);
    EXPECT_EQ(deformer->report().free_count, (width - 20) * (width - 20) - 1);
    EXPECT_LT(deformer->report().row_count, (width - 18) * (width - 18));
    Positions target = mesh.vertices.row(middle);
    target(0, 2) += 5.0;
    const Solution solution = solve(*deformer, target);
    EXPECT_EQ(solution.vertices.row(middle), target.row(0));
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if ((*binding.roi)[v]) continue;
        ASSERT_EQ(solution.vertices.row(v), mesh.vertices.row(v)) << v;
    }
    EXPECT_GT(solution.vertices(middle + 1, 2), mesh.vertices(middle + 1, 2) + 2.0);  // neighbors follow
}

TEST_P(EveryMethod, FixedVerticesFarFromTheRegionTakeNoMemory) {
    const Mesh mesh = grid(60, 60, 0.01);
    Binding binding = binding_of(mesh, {1830}, GetParam());
    binding.roi = inside_grid(60, 60, 25);
    const auto deformer = bound(binding);
    const std::size_t bytes_each = GetParam() == Method::kFull ? 4096 : 2048;
    EXPECT_LT(deformer->report().bytes, 200 * bytes_each);  // of 99 free vertices and what touches them, not of 3600
}

TEST_P(EveryMethod, APartWithoutAnchorsStaysAtRestWhereverASolveStarts) {
    const Mesh mesh = joined(sphere(3), torus(12, 8));
    const std::vector<Index> anchors = {0, 2, 4, 5};
    const auto deformer = bound_to(mesh, anchors, GetParam());
    ASSERT_EQ(deformer->report().components.size(), 2u);
    EXPECT_EQ(deformer->report().components[1].undetermined, 7);
    EXPECT_EQ(deformer->report().free_count, 254);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.2, {0, 1, 1}, 1.0, {1, 0, 0});
    const Positions targets = rows_of(moved, anchors);
    for (const Solution& solution : {solve(*deformer, targets), solve_from(*deformer, targets, moved)}) {
        EXPECT_EQ(solution.vertices.bottomRows(96), mesh.vertices.bottomRows(96));
        EXPECT_LT(largest_distance(solution.vertices.topRows(258), moved.topRows(258)), 1e-6);
    }
}

TEST_P(EveryMethod, FewAnchorsMoveTheShapeAlong) {
    for (const Mesh& mesh : {with_noise(sphere(3), 0.05, 1), mesh_for(GetParam())}) {
        const std::vector<Index> spread = spread_vertices(mesh, 3);
        for (std::ptrdiff_t count = 0; count <= 3; ++count) {
            const std::vector<Index> anchors(spread.begin(), spread.begin() + count);
            const Eigen::RowVector3d shift(count == 0 ? 0.0 : 0.5, 0.0, 0.0);
            const Positions moved = mesh.vertices.rowwise() + shift;
            const auto deformer = bound(binding_of(mesh, anchors, GetParam()));
            EXPECT_EQ(deformer->report().components.at(0).undetermined, (std::array{7, 4, 1, 0})[count]);
            const Solution solution = solve(*deformer, rows_of(moved, anchors));
            EXPECT_LT(largest_distance(solution.vertices, moved), 1e-4) << count;
        }
    }
}

TEST_P(EveryMethod, FewCollinearOrCoincidentAnchorsGiveFiniteAnswers) {
    Mesh mesh = with_noise(sphere(3), 0.05, 1);
    const std::vector<Index> spread = spread_vertices(mesh, 5);
    for (std::ptrdiff_t count = 1; count <= 5; ++count) {
        const std::vector<Index> anchors(spread.begin(), spread.begin() + count);
        const auto deformer = bound(binding_of(mesh, anchors, GetParam()));
        for (const double scale : {-1.0, 0.0, 1e-12, 3.0}) {
            const Solution solution = solve(*deformer, scale * rows_of(mesh.vertices, anchors));
            EXPECT_TRUE(solution.vertices.allFinite()) << count << " anchors, scale " << scale;
            EXPECT_LT(solution.vertices.cwiseAbs().maxCoeff(), 20.0) << count << " anchors, scale " << scale;
        }
    }
    // On one line at rest, and turned about it.
    const std::vector<Index> anchors(spread.begin(), spread.begin() + 4);
    for (int k = 0; k < 4; ++k)
        mesh.vertices.row(anchors[k]) << 0.3 * k - 0.5, 0.0, 1.2;
    const auto deformer = bound(binding_of(mesh, anchors, GetParam()));
    for (const double angle_rad : {0.0, 1.0, kPi}) {
        const Positions moved = moved_by_similarity(mesh.vertices, 1.0, {0, 0, 1}, angle_rad, {0, 1, 0});
        const Solution solution = solve(*deformer, rows_of(moved, anchors));
        EXPECT_TRUE(solution.vertices.allFinite());
        EXPECT_LT(solution.energy, 1e-6) << angle_rad;
    }
}

TEST_P(EveryMethod, CoincidingAndLooseVerticesAndLoneTrianglesDoNoHarm) {
    Mesh mesh = joined(sphere(3), triangle());
    mesh.vertices.row(7) = mesh.vertices.row(100);  // not neighbors
    mesh.vertices.row(mesh.faces(20, 0)) = mesh.vertices.row(mesh.faces(20, 1));
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.bottomRows(1) << 7, 7, 7;
    const std::vector<Index> anchors = spread_vertices(sphere(3), 5);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(2) *= 1.5;
    const Solution solution = solve(*bound(binding_of(mesh, anchors, GetParam())), targets);
    EXPECT_TRUE(solution.vertices.allFinite());
    EXPECT_LT(solution.vertices.topRows(258).cwiseAbs().maxCoeff(), 5.0);
    EXPECT_EQ(solution.vertices.bottomRows(4), mesh.vertices.bottomRows(4));
}

TEST_P(EveryMethod, NothingFreeIsSolvedAtOnce) {
    const Mesh mesh = triangle();
    const Solution solution = solve(*bound(binding_of(mesh, {0, 1, 2}, GetParam())), 2.0 * mesh.vertices);
    EXPECT_EQ(solution.vertices, Positions(2.0 * mesh.vertices));
    EXPECT_TRUE(solution.converged);
}

TEST_P(EveryMethod, SolvesForThePoleOfASphereOf160SegmentsAndRefusesAHubByName) {
    const Mesh tube = capped_tube(160, 4, 1.0);
    const std::vector<Index> anchors = {0, 50, 100, 480, 530, 580};
    const auto deformer = bound(binding_of(tube, anchors, GetParam()));
    EXPECT_GE(deformer->report().longest_ring, 160);
    const Positions moved = moved_by_similarity(tube.vertices, 1.0, {1, 2, 3}, 0.5, {1, 0, 0});
    EXPECT_LT(largest_distance(solve(*deformer, rows_of(moved, anchors)).vertices, moved), 1e-4);

    const Binding hubs = binding_of(capped_tube(3000, 2, 1.0), {0, 1000, 1500}, GetParam());
    const std::string text = message_of<InvalidInput>([&] { bound(hubs); });
    EXPECT_TRUE(contains(text, "neighbors that may move, and at most 2048")) << text;
    EXPECT_TRUE(contains(text, "vertex 6000 ") || contains(text, "vertex 6001 ")) << text;
}

TEST(Methods, KeepAnIterationLimitAndReportIt) {
    const Pulled pulled(with_noise(torus(80, 60), 0.05, 1));
    for (const Method method : {Method::kFast, Method::kFull}) {  // the third has a fixed number of sweeps
        const auto deformer = bound(binding_of(pulled.mesh, pulled.anchors, method));
        for (const int limit : {0, 2}) {
            const Solution solution = solve(*deformer, pulled.targets, {{}, limit});
            EXPECT_EQ(solution.iterations, limit);
            EXPECT_FALSE(solution.converged);
            EXPECT_EQ(solution.stop_reason, "iteration limit");
            EXPECT_TRUE(solution.vertices.allFinite());
            EXPECT_EQ(rows_of(solution.vertices, pulled.anchors), pulled.targets);
        }
    }
}

TEST_P(EveryMethod, IsCancelledAnywhereAndWorksOn) {
    const Pulled pulled(mesh_for(GetParam()));
    const Binding binding = binding_of(pulled.mesh, pulled.anchors, GetParam(), 1);
    const auto deformer = bound(binding);
    const Positions before = solve(*deformer, pulled.targets).vertices;
    const auto stages = cancelled_everywhere(
        [&](Execution& execution) { deformer->solve(pulled.targets, {}, SolveOptions(), execution); });
    EXPECT_EQ(stages.back(), "solve");
    EXPECT_EQ(solve(*deformer, pulled.targets).vertices, before);
    cancelled_everywhere([&](Execution& execution) { Deformer(binding, execution); });
    EXPECT_EQ(solve(*bound(binding), pulled.targets).vertices, before);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(kMethods));

}  // namespace
}  // namespace meanvalue::tests
