#include "meanvalue/decode/paper_decoder.h"

#include <cmath>
#include <memory>

#include "meanvalue/common/errors.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/optimise/gauss_newton_cg.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

std::unique_ptr<Deformer> bound_to(const Mesh& mesh, const std::vector<Index>& anchors,
                                   Method method = Method::kPaper, const std::optional<std::vector<char>>& roi = {},
                                   int threads = 1) {
    Execution execution;
    Binding binding(mesh.vertices, mesh.faces, anchors, roi);
    binding.method = method;
    binding.threads = threads;
    return std::make_unique<Deformer>(binding, execution);
}

Solution solve(Deformer& deformer, const Positions& targets) {
    Execution execution;
    return deformer.solve(targets, {}, SolveOptions(), execution);
}

double largest_distance(const Positions& a, const Positions& b) {
    return (a - b).rowwise().norm().maxCoeff();
}

class EveryPaperShape : public testing::TestWithParam<Mesh> {};

TEST_P(EveryPaperShape, RestAnchorsGiveTheRestShape) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Solution solution = solve(*bound_to(mesh, anchors), rows_of(mesh.vertices, anchors));
    EXPECT_LT(largest_distance(solution.vertices, mesh.vertices), 1e-9 * mesh.diagonal());
}

TEST_P(EveryPaperShape, AnchorsUnderOneSimilarityTakeTheShapeAlong) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.5, {3, 1, 2}, 2.0, {1, 2, 3});
    const Solution solution = solve(*bound_to(mesh, anchors), rows_of(moved, anchors));
    EXPECT_LT(largest_distance(solution.vertices, moved), 1e-9 * 1.5 * mesh.diagonal());
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryPaperShape,
                         testing::Values(sphere(4), grid(20, 18, 0.02), torus(30, 16), with_noise(sphere(4), 0.05, 1),
                                         capped_tube(16, 40, 12.0)));

/// A tube bent by its upper end.
struct Bend {
    Mesh mesh = capped_tube(16, 60, 18.0);
    std::vector<Index> anchors;
    Positions targets;

    Bend() {
        for (Index v = 0; v < 16; v += 4) {
            anchors.push_back(v);
            anchors.push_back(59 * 16 + v);
        }
        targets = rows_of(mesh.vertices, anchors);
        const Positions turned = moved_by_similarity(mesh.vertices, 1.0, Vector3::UnitX(), 0.8, {0, 5, -1});
        for (std::size_t k = 1; k < anchors.size(); k += 2)
            targets.row(k) = turned.row(anchors[k]);
    }
};

TEST(PaperDecoder, ComesNearTheMinimumFromAbove) {
    const Bend bend;
    const Solution paper = solve(*bound_to(bend.mesh, bend.anchors), bend.targets);
    const Solution full = solve(*bound_to(bend.mesh, bend.anchors, Method::kFull), bend.targets);
    EXPECT_LT(paper.energy, paper.initial_energy);
    EXPECT_GE(paper.energy, full.energy * (1 - 1e-6));
    // Measured: 26 times. The rings at single-vertex anchors are what four sweeps do not bring to rest.
    std::cout << "G of paper over that of full: " << paper.energy / full.energy << ", over that of the start "
              << paper.energy / paper.initial_energy << "\n";
    EXPECT_LT(paper.energy, 40.0 * full.energy);
    EXPECT_TRUE(paper.converged);
    EXPECT_GT(paper.initial_gradient, 0.0);
    EXPECT_LT(paper.gradient, paper.initial_gradient);
    for (std::size_t k = 0; k < bend.anchors.size(); ++k) {
        EXPECT_EQ(paper.vertices.row(bend.anchors[k]), bend.targets.row(k));
    }
}

TEST(PaperDecoder, ReportsItsLevelsAndStages) {
    const Bend bend;
    const auto deformer = bound_to(bend.mesh, bend.anchors);
    const std::vector<Index>& sizes = deformer->report().level_sizes;
    ASSERT_EQ(sizes.size(), 3u);
    EXPECT_EQ(sizes[0], bend.mesh.vertex_count() - 8);
    EXPECT_EQ(sizes[1], static_cast<Index>(std::ceil(0.03 * sizes[0])));
    EXPECT_LT(sizes[2], sizes[1]);
    const Solution solution = solve(*deformer, bend.targets);
    for (const char* stage : {"base", "split", "optimise", "relax"})
        EXPECT_EQ(solution.timings.count(stage), 1u);
    EXPECT_LT(deformer->report().bytes, 2048u * bend.mesh.vertex_count());
}

TEST(PaperDecoder, GivesTheSameBitsForAnyNumberOfThreadsAndEachTime) {
    const Mesh mesh = with_noise(torus(80, 60), 0.05, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0);
    const auto deformer = bound_to(mesh, anchors, Method::kPaper, {}, 4);
    const Positions first = solve(*deformer, targets).vertices;
    EXPECT_EQ(first, solve(*deformer, targets).vertices);
    EXPECT_EQ(first, solve(*bound_to(mesh, anchors, Method::kPaper, {}, 1), targets).vertices);
}

TEST(PaperDecoder, FixedVerticesFarFromTheRegionDoNotEnter) {
    const Mesh mesh = grid(40, 40, 0.01);
    std::vector<char> roi(1600, 0);
    for (Index r = 15; r < 25; ++r) {
        for (Index c = 15; c < 25; ++c)
            roi[40 * r + c] = 1;
    }
    const auto deformer = bound_to(mesh, {820}, Method::kPaper, roi);
    EXPECT_LT(deformer->report().bytes, 2048u * 200);  // of 99 free vertices and what touches them, not of 1600
    Positions target = mesh.vertices.row(820);
    target(0, 2) += 3.0;
    const Solution solution = solve(*deformer, target);
    for (Index v = 0; v < 1600; ++v) {
        if (roi[v]) continue;
        ASSERT_EQ(solution.vertices.row(v), mesh.vertices.row(v)) << v;
    }
    EXPECT_GT(solution.vertices(819, 2), mesh.vertices(819, 2) + 1.0);
}

TEST(PaperDecoder, FewCoincidentOrCollinearAnchorsGiveFiniteAnswersNearTheStart) {
    Mesh mesh = with_noise(sphere(3), 0.05, 1);
    const std::vector<Index> spread = spread_vertices(mesh, 3);
    for (std::size_t count = 1; count <= 3; ++count) {
        const std::vector<Index> anchors(spread.begin(), spread.begin() + static_cast<std::ptrdiff_t>(count));
        Positions targets = rows_of(mesh.vertices, anchors);
        targets.array() += 0.5;
        const Solution moved = solve(*bound_to(mesh, anchors), targets);
        ASSERT_TRUE(moved.vertices.allFinite()) << count;
        EXPECT_LT(largest_distance(moved.vertices, (mesh.vertices.array() + 0.5).matrix()), 1e-4) << count;
    }
    // Coincident targets, and anchors that lie on one line at rest.
    const std::vector<Index> anchors = spread_vertices(mesh, 5);
    EXPECT_TRUE(solve(*bound_to(mesh, anchors), Positions::Constant(5, 3, 0.2)).vertices.allFinite());
    for (int k = 0; k < 4; ++k)
        mesh.vertices.row(anchors[k]) << 0.3 * k, 0.0, 1.2;
    EXPECT_TRUE(solve(*bound_to(mesh, {anchors.begin(), anchors.begin() + 4}),
                      rows_of(mesh.vertices, {anchors.begin(), anchors.begin() + 4}))
                    .vertices.allFinite());
}

TEST(PaperDecoder, APartWithoutAnchorsStaysWhereItIs) {
    const Mesh mesh = joined(sphere(3), torus(12, 8));
    const std::vector<Index> anchors = {0, 2, 4, 5};
    const auto deformer = bound_to(mesh, anchors);
    EXPECT_EQ(deformer->report().components.at(1).undetermined, 7);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.2, {0, 1, 1}, 1.0, {1, 0, 0});
    const Solution solution = solve(*deformer, rows_of(moved, anchors));
    EXPECT_EQ(solution.vertices.bottomRows(96), mesh.vertices.bottomRows(96));
    EXPECT_LT(largest_distance(solution.vertices.topRows(258), moved.topRows(258)), 1e-8);
}

TEST(PaperDecoder, CancelLeavesItUsable) {
    const Bend bend;
    const auto deformer = bound_to(bend.mesh, bend.anchors);
    const Positions before = solve(*deformer, bend.targets).vertices;
    Execution cancelled;
    cancelled.cancel();
    EXPECT_THROW(deformer->solve(bend.targets, {}, SolveOptions(), cancelled), Cancelled);
    EXPECT_EQ(solve(*deformer, bend.targets).vertices, before);
}

TEST(PaperDecoder, CancelsAtAnyPlaceAndStaysUsable) {
    const Mesh mesh = torus(80, 60);
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    const auto deformer = bound_to(mesh, anchors);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0);
    const Positions before = solve(*deformer, targets).vertices;
    // The whole of it takes more than a hundred looks: base, both splits, the coarse level and the sweeps.
    int cancels = 0;
    const auto solved = [&](Execution& execution) {
        ++cancels;
        deformer->solve(targets, {}, SolveOptions(), execution);
    };
    cancelled_everywhere(solved);
    EXPECT_GT(cancels, 30);
    EXPECT_EQ(solve(*deformer, targets).vertices, before);
    const auto bind = [&](Execution& execution) {
        Deformer(binding_of(mesh, anchors, Method::kPaper, 1), execution);
    };
    EXPECT_EQ(cancelled_everywhere(bind).back(), "encode");
}

TEST(PaperDecoder, RefusesPositionsWhoseEnergyOverflows) {
    const Bend bend;
    Execution execution;
    Region region{{}, bend.mesh.vertices, bend.mesh.faces, std::vector<char>(bend.mesh.vertex_count(), 0)};
    for (Index v = 0; v < bend.mesh.vertex_count(); ++v)
        region.vertices.push_back(v);
    for (const Index v : bend.anchors)
        region.is_fixed[v] = 1;
    const PaperDecoder decoder(encode_region(std::move(region), {}, 1, execution), 1, execution);
    const auto workspace = decoder.make_workspace(execution);
    for (const double far : {1e160, 1e300}) {
        Positions positions = bend.mesh.vertices;
        positions(bend.anchors[1], 2) = far;
        const auto decode = [&] { decoder.decode({}, *workspace, positions, execution); };
        EXPECT_TRUE(contains(message_of<SolverFailure>(decode), "not finite")) << far;
    }
    Positions positions = bend.mesh.vertices;
    decoder.decode({}, *workspace, positions, execution);
    EXPECT_TRUE(positions.allFinite());
}

TEST(PaperDecoder, DoesNotCallALineSearchThatFailedConverged) {
    MinimiseReport report;
    report.initial_gradient = 1.0;
    report.gradient = 0.5;
    report.stop_reason = StopReason::kNoDescent;
    EXPECT_FALSE(report.converged());
    // A gradient that is no number leads nowhere: the end is told as what it is.
    const Mesh mesh = capped_tube(12, 12, 6.0);
    const Encoding encoding = encoding_of(mesh);
    std::vector<char> fixed(mesh.vertex_count(), 0);
    fixed[0] = fixed[1] = 1;
    const Unknowns unknowns = find_unknowns(encoding, fixed);
    Execution execution;
    const GaussNewtonSystem system(encoding, unknowns, execution);
    auto at = system.make_workspace(execution);
    Positions positions = mesh.vertices;
    positions(0, 0) = 1e200;
    const MinimiseReport failed =
        GaussNewtonCg(system, unknowns, execution).minimise(0.0, 1, positions, execution, at);
    EXPECT_EQ(failed.stop_reason, StopReason::kNoDescent);
    EXPECT_FALSE(failed.converged());
}

TEST(GaussNewtonCg, EnergyNeverRisesAndTheGradientVanishes) {
    const Mesh mesh = capped_tube(12, 12, 6.0);
    const Encoding encoding = encoding_of(mesh);
    std::vector<char> fixed(mesh.vertex_count(), 0);
    for (Index v = 0; v < 12; ++v)
        fixed[v] = fixed[11 * 12 + v] = 1;
    const Unknowns unknowns = find_unknowns(encoding, fixed);
    Execution execution;
    const GaussNewtonSystem system(encoding, unknowns, execution);
    auto at = system.make_workspace(execution);
    Positions positions = mesh.vertices;
    for (Index v = 0; v < 12; ++v)
        positions(v, 0) += 1.5;
    system.linearise(positions, nullptr, 1, execution, at);
    const double start = at.gradient.norm();
    const MinimiseReport report =
        GaussNewtonCg(system, unknowns, execution).minimise(0.0, 1, positions, execution, at);
    for (std::size_t k = 1; k < report.energies.size(); ++k)
        EXPECT_LT(report.energies[k], report.energies[k - 1]);
    system.linearise(positions, nullptr, 1, execution, at);
    EXPECT_LT(at.gradient.norm(), 1e-2 * start);
}

TEST(GaussSeidel, LeavesAVertexThatItsRowsDoNotDetermineWhereItIs) {
    // A loose vertex has no row of its own. In the ring of the middle it takes the place of another one with a weight
    // that hardly counts: it turns the flat ring's normal and changes a distance, and that is rank two.
    Mesh mesh = grid(3, 3, 0.0);
    Encoding encoding = encoding_of(mesh);
    encoding.ring_offsets.push_back(encoding.ring_offsets.back());
    encoding.softening.push_back(0.0);
    encoding.steep_offset.push_back(-1);
    mesh.vertices.conservativeResize(10, 3);
    const Index place = encoding.ring_offsets[4];
    mesh.vertices.row(9) = mesh.vertices.row(encoding.ring[place]);
    encoding.ring[place] = 9;
    encoding.weights[place] = 1e-7;
    for (Index k = encoding.ring_offsets[4]; k < encoding.ring_offsets[5]; ++k)
        encoding.heights[k] = 0.2;
    std::vector<char> fixed(10, 1);
    fixed[9] = 0;
    const Unknowns unknowns = find_unknowns(encoding, fixed);
    ASSERT_EQ(unknowns.rows, (std::vector<Index>{4}));
    const GaussSeidel relaxation(encoding, unknowns, Execution());
    Positions positions = mesh.vertices;
    positions(9, 0) += 0.1;
    const Positions before = positions;
    relaxation.sweep(positions, 1, Execution());
    EXPECT_EQ(positions, before);
}

TEST(GaussSeidel, SweepsLowerTheEnergyTowardsTheMinimum) {
    const Mesh mesh = with_noise(sphere(3), 0.1, 1);
    const Encoding encoding = encoding_of(mesh);
    std::vector<char> fixed(mesh.vertex_count(), 0);
    fixed[0] = fixed[1] = fixed[2] = fixed[3] = 1;
    const Unknowns unknowns = find_unknowns(encoding, fixed);
    const Execution execution;
    const GaussSeidel relaxation(encoding, unknowns, execution);
    Positions positions = with_noise(mesh, 0.1, 9).vertices;
    double energy = meanvalue::energy(encoding, positions, 1, execution);
    const double start = energy;
    for (int sweep = 0; sweep < 20; ++sweep) {
        relaxation.sweep(positions, 1, execution);
        const double after = meanvalue::energy(encoding, positions, 1, execution);
        EXPECT_LT(after, energy * (1 + 1e-9)) << sweep;
        energy = after;
    }
    EXPECT_LT(energy, 0.1 * start);
}

}  // namespace
}  // namespace meanvalue::tests
