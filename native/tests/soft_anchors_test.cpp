// Anchors with strengths: what the springs of the fast method do, on meshes with and without a coarse level.
#include <algorithm>
#include <cmath>
#include <limits>

#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/mesh/extent.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

constexpr double kHard = std::numeric_limits<double>::infinity();
const SolveOptions kFine{1e-8, 2000};

Binding soft_binding(const Mesh& mesh, const std::vector<Index>& anchors, const std::vector<double>& strengths,
                     std::optional<double> rigidity = {}, int threads = 1) {
    Binding binding = binding_of(mesh, anchors, Method::kFast, threads, rigidity);
    binding.strengths = strengths;
    return binding;
}

std::unique_ptr<Deformer> soft_bound_to(const Mesh& mesh, const std::vector<Index>& anchors,
                                        const std::vector<double>& strengths, std::optional<double> rigidity = {},
                                        int threads = 1) {
    return bound(soft_binding(mesh, anchors, strengths, rigidity, threads));
}

/// Every second anchor hard, the others of this strength.
std::vector<double> mixed(std::size_t count, double strength) {
    std::vector<double> strengths(count, strength);
    for (std::size_t k = 0; k < count; k += 2)
        strengths[k] = kHard;
    return strengths;
}

/// The anchors of the lower end hard, those of the upper end of this strength.
std::vector<double> soft_above(const Pose& pose, double strength) {
    const double middle = 0.5 * pose.mesh.vertices.col(2).maxCoeff();
    std::vector<double> strengths;
    strengths.reserve(pose.anchors.size());
    for (const Index v : pose.anchors)
        strengths.push_back(pose.mesh.vertices(v, 2) > middle ? strength : kHard);
    return strengths;
}

/// A bend without a coarse level, one with, and isolated anchors. No handle is longer than two rings, or what is
/// beyond would take part only with soft anchors, and its size with it.
std::vector<Pose> soft_poses() {
    return {bend("bend", capped_tube(16, 25, 8.0), 1.0), bend("bend of a large tube", capped_tube(48, 75, 8.0), 1.0),
            spread_pull("pull of a sphere", sphere(4), 6, {0.3, 0.2, 0.0}),
            spread_pull("pull of a large sphere", sphere(5), 6, {0.3, 0.2, 0.0})};
}

class SoftShape : public testing::TestWithParam<Mesh> {};

TEST_P(SoftShape, TargetsThatRestOrMoveRigidlyTakeTheShapeAlong) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 16);
    for (const double strength : {1e-4, 1.0, 1e6, kHard}) {
        for (const auto& strengths : {std::vector<double>(16, strength), mixed(16, strength)}) {
            const auto deformer = soft_bound_to(mesh, anchors, strengths);
            for (const double angle_deg : {0.0, 20.0, 180.0}) {
                const Vector3 shift = angle_deg == 0.0 ? Vector3(0, 0, 0) : Vector3(5, -2, 1);
                const Positions moved =
                    moved_by_similarity(mesh.vertices, 1.0, {1, 2, 3}, angle_deg * kPi / 180, shift);
                const Solution solution = solve(*deformer, rows_of(moved, anchors));
                EXPECT_LT(largest_distance(solution.vertices, moved), 1e-9 * mesh.diagonal())
                    << strength << ", " << angle_deg << " degrees";
                EXPECT_TRUE(solution.converged);
            }
        }
    }
}

TEST_P(SoftShape, WithoutRigidityASimilarityOfTheTargetsIsMet) {
    const Mesh& mesh = GetParam();
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    const Positions moved = moved_by_similarity(mesh.vertices, 1.7, {3, 1, 2}, 2.0, {1, 2, 3});
    for (const auto& strengths : {std::vector<double>(8, 0.5), mixed(8, 0.5)}) {
        const Solution solution = solve(*soft_bound_to(mesh, anchors, strengths, 0.0), rows_of(moved, anchors));
        EXPECT_LT(largest_distance(solution.vertices, moved), 1e-9 * mesh.diagonal());
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, SoftShape,
                         testing::Values(with_noise(sphere(3), 0.1, 1), grid(20, 18, 0.02), capped_tube(16, 12, 6.0),
                                         bar(4, 16), sphere(5), torus(80, 60)));

class SoftPose : public testing::TestWithParam<Pose> {};

TEST_P(SoftPose, TheMoreStrengthTheNearerToTheHardSolution) {
    const Pose& pose = GetParam();
    const Positions hard = solve(*bound_to(pose.mesh, pose.anchors), pose.targets, kFine).vertices;
    double last = 0.0;
    for (const double strength : {1e2, 1e3, 1e4}) {
        const auto deformer = soft_bound_to(pose.mesh, pose.anchors, soft_above(pose, strength));
        const Solution solution = solve(*deformer, pose.targets, kFine);
        const double off = largest_distance(solution.vertices, hard) / pose.mesh.diagonal();
        EXPECT_LT(off, 0.3 / strength) << strength;
        if (last > 0.0) {
            EXPECT_LT(off, std::max(0.2 * last, 1e-7)) << strength;  // as 1 / s, down to what the solver tells apart
        }
        last = off;
    }
    const std::vector<double> infinite(pose.anchors.size(), kHard);
    EXPECT_EQ(solve(*soft_bound_to(pose.mesh, pose.anchors, infinite), pose.targets, kFine).vertices, hard);
}

TEST_P(SoftPose, AWeakSpringBarelyMovesAnything) {
    const Pose& pose = GetParam();
    const auto strengths = soft_above(pose, 1e-9);
    const Solution solution = solve(*soft_bound_to(pose.mesh, pose.anchors, strengths), pose.targets);
    Positions still = pose.mesh.vertices;
    for (std::size_t k = 0; k < pose.anchors.size(); ++k) {
        if (std::isinf(strengths[k])) still.row(pose.anchors[k]) = pose.targets.row(k);
    }
    if (largest_distance(still, pose.mesh.vertices) > 0.0) return;  // the pull is at a hard anchor
    EXPECT_LT(largest_distance(solution.vertices, still), 1e-3 * pose.mesh.diagonal());
}

TEST_P(SoftPose, HardAnchorsAreMetExactlyAndSoftOnesGiveWayWithTheSameBitsForAnyNumberOfThreads) {
    const Pose& pose = GetParam();
    const auto strengths = mixed(pose.anchors.size(), 0.01);
    const auto one = soft_bound_to(pose.mesh, pose.anchors, strengths, {}, 1);
    const auto four = soft_bound_to(pose.mesh, pose.anchors, strengths, {}, 4);
    const Solution solution = solve(*one, pose.targets);
    expect_energy_never_rises(solution);
    EXPECT_TRUE(solution.converged);
    for (std::size_t k = 0; k < pose.anchors.size(); ++k) {
        if (std::isfinite(strengths[k])) continue;
        EXPECT_EQ(solution.vertices.row(pose.anchors[k]), pose.targets.row(k));
    }
    EXPECT_GT(largest_distance(rows_of(solution.vertices, pose.anchors), pose.targets), 0.0);
    EXPECT_EQ(solution.vertices, solve(*four, pose.targets).vertices);
    EXPECT_EQ(solution.energies, solve(*one, pose.targets).energies);
    const Positions further = 1.02 * pose.targets;
    EXPECT_EQ(solve_from(*one, further, solution.vertices).vertices,
              solve_from(*four, further, solution.vertices).vertices);
}

TEST_P(SoftPose, TheSolutionIsAMinimumOfAnEnergyWithTheSprings) {
    const Pose& pose = GetParam();
    const auto strengths = soft_above(pose, 0.02);
    const Solution solution = solve(*soft_bound_to(pose.mesh, pose.anchors, strengths), pose.targets, kFine);
    // The same energy, put together by hand.
    const Encoding encoding = encoding_of(pose.mesh);
    std::vector<char> is_fixed(pose.mesh.vertex_count(), 0);
    std::vector<SoftAnchor> soft;
    for (std::size_t k = 0; k < pose.anchors.size(); ++k) {
        if (std::isinf(strengths[k])) {
            is_fixed[pose.anchors[k]] = 1;
        } else {
            soft.push_back({pose.anchors[k], static_cast<Index>(k), strengths[k]});
        }
    }
    const Unknowns unknowns = find_unknowns(encoding, is_fixed);
    Execution execution;
    const RestCells cells = rest_cells(encoding, pose.mesh.vertices, 1, execution);
    const DeformationEnergy energy(encoding, unknowns, cells, mean_diagonal(pose.mesh.vertices, 1, execution), 1.0,
                                   execution, InstructionSet::kFastest, SoftConstraints(soft, unknowns));
    auto workspace = energy.make_workspace();
    workspace.soft_targets = energy.soft_constraints().targets_of(pose.targets);
    Positions gradient(static_cast<Eigen::Index>(unknowns.free.size()), 3);
    const auto energy_at = [&](const Positions& positions) {
        return energy.evaluate(positions, kDefaultRigidity, gradient, 1, execution, workspace);
    };
    const double least = energy_at(solution.vertices);
    EXPECT_NEAR(solution.energy, least, 1e-6 * least);
    EXPECT_NEAR(gradient.norm(), solution.gradient, 1e-6 * pose.mesh.diagonal());
    EXPECT_LT(gradient.norm(), 1e-5 * pose.mesh.diagonal());
    for (std::size_t k = 0; k < soft.size(); k += 1 + soft.size() / 8) {
        for (int c = 0; c < 6; ++c) {
            Positions moved = solution.vertices;
            moved(soft[k].vertex, c / 2) += (c % 2 == 0 ? 1e-3 : -1e-3) * pose.mesh.diagonal();
            EXPECT_GT(energy_at(moved), least);
        }
    }
}

TEST_P(SoftPose, FollowingLeadsWhereASolveFromRestDoes) {
    const Pose& pose = GetParam();
    const Positions rest = rows_of(pose.mesh.vertices, pose.anchors);
    for (const auto& strengths : {soft_above(pose, 0.05), std::vector<double>(pose.anchors.size(), 1.0)}) {
        const auto deformer = soft_bound_to(pose.mesh, pose.anchors, strengths);
        Deformer::Drag drag(*deformer);
        Positions shape;
        for (const double share : {0.9, 0.95, 1.0}) {
            const Positions targets = rest + share * (pose.targets - rest);
            shape = solve_next(drag, targets, share < 1.0 ? SolveOptions() : kFine).vertices;
        }
        EXPECT_LT(largest_distance(shape, solve(*deformer, pose.targets, kFine).vertices),
                  1e-5 * pose.mesh.diagonal());
    }
}

TEST_P(SoftPose, UnmovedTargetsOfWeakSpringsAreNotFollowedAgain) {
    // The shape lags far behind its targets, and is in balance there.
    const Pose& pose = GetParam();
    const auto deformer = soft_bound_to(pose.mesh, pose.anchors, std::vector<double>(pose.anchors.size(), 1e-4));
    const Solution first = solve(*deformer, pose.targets);
    const Solution again = solve_from(*deformer, pose.targets, first.vertices);
    EXPECT_LE(again.all_iterations, 10);
    EXPECT_LE(again.energy, first.energy);
}

INSTANTIATE_TEST_SUITE_P(Poses, SoftPose, testing::ValuesIn(soft_poses()));

TEST(SoftAnchors, DenseOnesAreThinnedOutOnTheCoarseLevelAndTheirTotalIsKept) {
    const Mesh mesh = sphere(5);
    Execution execution;
    CoarseningOptions options;
    options.level_sizes = {1000};
    options.down_to_base = false;
    options.thin_out_fixed = true;
    options.is_soft.assign(mesh.vertex_count(), 0);
    std::vector<char> is_fixed(mesh.vertex_count(), 0);
    std::vector<SoftAnchor> soft;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        options.is_soft[v] = mesh.vertices(v, 2) > 0.5 ? 1 : 0;
        is_fixed[v] = mesh.vertices(v, 2) < -0.8 ? 1 : 0;
        if (options.is_soft[v]) soft.push_back({v, static_cast<Index>(soft.size()), 0.25 + 0.5 * (v % 3)});
    }
    const Hierarchy hierarchy = build_hierarchy(rings_of(mesh), mesh.vertices, is_fixed, options, 1, execution);
    EXPECT_EQ(hierarchy.base().free_count, 1000);
    const std::vector<SoftAnchor> coarse =
        coarse_soft_anchors(soft, hierarchy, hierarchy.base(), mesh.vertex_count(), 2.0);
    EXPECT_GT(coarse.size(), 10u);
    EXPECT_LT(coarse.size(), soft.size() / 2);
    double total = 0.0;
    double coarse_total = 0.0;
    for (const SoftAnchor& anchor : soft)
        total += anchor.strength;
    for (const SoftAnchor& anchor : coarse) {
        coarse_total += anchor.strength;
        EXPECT_TRUE(options.is_soft[anchor.vertex]);
        EXPECT_EQ(std::count(hierarchy.order.begin(), hierarchy.order.end(), anchor.vertex), 0);
    }
    EXPECT_NEAR(coarse_total, 2.0 * total, 1e-9 * total);
}

TEST(SoftAnchors, HoldAPartAsHardOnesDo) {
    const Mesh mesh = joined(sphere(3), torus(12, 8));
    const std::vector<Index> spread = spread_vertices(sphere(3), 4);
    for (std::size_t count = 1; count <= 4; ++count) {
        const std::vector<Index> anchors(spread.begin(), spread.begin() + static_cast<std::ptrdiff_t>(count));
        const auto deformer = soft_bound_to(mesh, anchors, std::vector<double>(count, 0.1));
        const Component& part = deformer->report().components[0];
        EXPECT_EQ(part.undetermined, count == 1 ? 4 : count == 2 ? 1 : 0);
        EXPECT_EQ(part.soft_count, static_cast<Index>(count));
        EXPECT_EQ(part.fixed_count, 0);
        EXPECT_EQ(part.free_count, 258);
        EXPECT_EQ(deformer->report().components[1].undetermined, 7);
        EXPECT_EQ(deformer->report().free_count, 258);
        const Positions shifted = mesh.vertices.rowwise() + Eigen::RowVector3d(0.5, 0, 0);
        const Solution solution = solve(*deformer, rows_of(shifted, anchors));
        EXPECT_LT(largest_distance(solution.vertices.topRows(258), shifted.topRows(258)), 1e-6) << count;
        EXPECT_EQ(solution.vertices.bottomRows(96), mesh.vertices.bottomRows(96));
    }
}

TEST(SoftAnchors, AlongTheirHandlesWayFarTurnsAreFollowed) {
    for (const Mesh& mesh : {capped_tube(16, 25, 8.0), capped_tube(40, 90, 8.0)}) {
        const Pose pose = bend("bend", mesh, 2.5);
        Positions hard = solve(*bound_to(mesh, pose.anchors), pose.targets).vertices;
        const auto deformer = soft_bound_to(mesh, pose.anchors, soft_above(pose, 100.0));
        EXPECT_LT(largest_distance(solve(*deformer, pose.targets).vertices, hard), 0.01 * mesh.diagonal());
    }
}

TEST(SoftAnchors, ExtremeStrengthsGiveFiniteAnswers) {
    const Pose pose = soft_poses()[1];
    for (const double strength : {1e-300, 1e-12, 1e9}) {
        for (const auto& strengths :
             {std::vector<double>(pose.anchors.size(), strength), soft_above(pose, strength)}) {
            for (const double rigidity : {0.0, kDefaultRigidity, 1e9}) {
                const Solution solution =
                    solve(*soft_bound_to(pose.mesh, pose.anchors, strengths, rigidity), pose.targets);
                EXPECT_TRUE(solution.vertices.allFinite());
                EXPECT_LT(solution.vertices.cwiseAbs().maxCoeff(), 20.0);
                expect_energy_never_rises(solution);
            }
        }
    }
}

TEST(SoftAnchors, ALooseSoftVertexGoesToItsTarget) {
    Mesh mesh = sphere(3);
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.bottomRows(1) << 7, 7, 7;
    const std::vector<Index> anchors = {0, 2, 4, 258};
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) << 1, 2, 3;
    const Solution solution = solve(*soft_bound_to(mesh, anchors, {kHard, kHard, kHard, 2.0}), targets);
    EXPECT_LT((solution.vertices.row(258) - targets.row(3)).norm(), 1e-4);
}

std::string refusal(const std::vector<double>& strengths, Method method = Method::kFast,
                    const std::optional<std::vector<char>>& roi = {}) {
    const Mesh mesh = sphere(2);
    Binding binding = soft_binding(mesh, {5, 6, 7}, strengths);
    binding.method = method;
    binding.roi = roi;
    return message_of<InvalidInput>([&] { bound(binding); });
}

TEST(SoftAnchorsReject, StrengthsThatMakeNoSense) {
    EXPECT_EQ(refusal({1.0, 2.0}), "strengths has 2 numbers, but there are 3 anchors; give one number for each");
    const std::string mend = "; give a positive number, or infinity for an anchor that is met exactly";
    EXPECT_EQ(refusal({1.0, 0.0, 2.0}), "strengths[1], of vertex 6, is 0" + mend);
    EXPECT_EQ(refusal({1.0, kHard, -2.0}), "strengths[2], of vertex 7, is -2" + mend);
    EXPECT_EQ(refusal({1.0, -kHard, 2.0}), "strengths[1], of vertex 6, is -inf" + mend);
    EXPECT_TRUE(contains(refusal({std::numeric_limits<double>::quiet_NaN(), 1.0, 1.0}), "strengths[0], of vertex 5"));
    EXPECT_TRUE(contains(refusal({1e10, 1.0, 1.0}), "give at most 1e+09, or infinity"));
    for (const Method method : {Method::kPaper, Method::kFull}) {
        EXPECT_EQ(refusal({kHard, 1.0, kHard}, method),
                  "strengths[1], of vertex 6, is 1; only method 'fast' has soft anchors: use it, or give infinity or "
                  "None");
        EXPECT_TRUE(contains(refusal({kHard, 0.0, kHard}, method), mend));
        EXPECT_TRUE(contains(refusal({kHard}, method), "strengths has 1"));
    }
    std::vector<char> roi(sphere(2).vertex_count(), 1);
    roi[6] = 0;
    EXPECT_EQ(
        refusal({1.0, 3.0, 1.0}, Method::kFast, roi),
        "strengths[1], of vertex 6, is 3, but lies outside the region of influence, where nothing is free; take "
        "it into the region, or give infinity for an anchor that is met exactly");
}

}  // namespace
}  // namespace meanvalue::tests
