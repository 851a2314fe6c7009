#include <Eigen/QR>
#include <cmath>
#include <functional>

#include "meanvalue/encoding/predictor.h"
#include "meanvalue/linalg/procrustes.h"
#include "reference/arap.h"
#include "reference/laplacian.h"
#include "reference/laplacian_surface_editing.h"
#include "reference/pyramid.h"
#include "reference/rotation_invariant.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

using baselines::Problem;

struct Baseline {
    std::string name;
    std::function<Positions(const Problem&, Execution&)> deform;
};

void PrintTo(const Baseline& method, std::ostream* stream) {
    *stream << method.name;
}

Baseline laplacian() {
    return {"laplacian", baselines::laplacian};
}

Baseline editing(int rounds) {
    return {"surface editing x" + std::to_string(rounds), [rounds](const Problem& problem, Execution& execution) {
                return baselines::laplacian_surface_editing(problem, {rounds}, execution);
            }};
}

Baseline pyramid() {
    return {"pyramid",
            [](const Problem& problem, Execution& execution) { return baselines::pyramid(problem, {}, execution); }};
}

Baseline arap() {
    return {"arap",
            [](const Problem& problem, Execution& execution) { return baselines::arap(problem, {}, execution); }};
}

Baseline rotation_invariant() {
    return {"rotation invariant", baselines::rotation_invariant};
}

std::vector<Baseline> all_methods() {
    return {laplacian(), editing(1), editing(5), pyramid(), arap(), rotation_invariant()};
}

Positions deform(const Baseline& method, const Mesh& mesh, const std::vector<Index>& anchors,
                 const Positions& targets, const std::optional<std::vector<char>>& roi = {}, int threads = 1) {
    Execution execution;
    return method.deform({mesh.vertices, mesh.faces, anchors, targets, roi, threads}, execution);
}

/// A tube whose lower end is held and whose upper end is turned sideways.
Pose bent_tube(double angle_rad) {
    return bend("bend", capped_tube(16, 25, 8.0), angle_rad);
}

Problem problem_of(const Pose& pose) {
    return {pose.mesh.vertices, pose.mesh.faces, pose.anchors, pose.targets, {}, 1};
}

class EveryBaseline : public testing::TestWithParam<Baseline> {};

TEST_P(EveryBaseline, UnmovedAnchorsGiveTheRestShape) {
    for (const Mesh& mesh : all_classes()) {
        const std::vector<Index> anchors = spread_vertices(mesh, 3);
        const Positions deformed = deform(GetParam(), mesh, anchors, rows_of(mesh.vertices, anchors));
        // Pyramid coordinates put vertices back one upon another: along needles rounding grows to some 1e-9.
        const double rounding = mesh.name == "needles" ? 1e-8 : 1e-9;
        EXPECT_LT(largest_distance(deformed, mesh.vertices), rounding * mesh.diagonal()) << mesh.name;
    }
}

TEST_P(EveryBaseline, ATranslationOfAllAnchorsTakesTheShapeAlong) {
    for (const Mesh& mesh : {torus(24, 12), grid(9, 8, 0.05), with_noise(sphere(3), 0.1, 1)}) {
        const std::vector<Index> anchors = spread_vertices(mesh, 5);
        const Positions moved = mesh.vertices.rowwise() + Eigen::RowVector3d(3, -7, 5);
        EXPECT_LT(largest_distance(deform(GetParam(), mesh, anchors, rows_of(moved, anchors)), moved),
                  1e-9 * mesh.diagonal())
            << mesh.name;
    }
}

TEST_P(EveryBaseline, AnchorsAreMetExactly) {
    const Pose bend = bent_tube(1.0);
    const Positions deformed = deform(GetParam(), bend.mesh, bend.anchors, bend.targets);
    EXPECT_EQ(rows_of(deformed, bend.anchors), bend.targets);
    EXPECT_TRUE(deformed.allFinite());
}

TEST_P(EveryBaseline, OutsideTheRegionOfInfluenceNothingMoves) {
    const Mesh mesh = grid(15, 15, 0.02);
    const std::vector<char> roi = inside_grid(15, 15, 4);
    Positions target = mesh.vertices.row(112);
    target(0, 2) += 2.0;
    const Positions deformed = deform(GetParam(), mesh, {112}, target, roi);
    for (Index v = 0; v < 225; ++v) {
        if (roi[v]) continue;
        EXPECT_EQ(deformed.row(v), mesh.vertices.row(v)) << v;
    }
    EXPECT_GT(deformed(111, 2), mesh.vertices(111, 2) + 0.2);  // neighbours follow
}

TEST_P(EveryBaseline, APartWithoutAnchorsStaysWhereItIs) {
    Mesh mesh = joined(sphere(2), grid(5, 5, 0.1));
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.bottomRows(1) << 7, 7, 7;  // a loose vertex
    const std::vector<Index> anchors = {0, 2, 4, 5};
    const Positions moved = mesh.vertices.rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Positions deformed = deform(GetParam(), mesh, anchors, rows_of(moved, anchors));
    EXPECT_EQ(deformed.bottomRows(26), mesh.vertices.bottomRows(26));
    EXPECT_LT(largest_distance(deformed.topRows(66), moved.topRows(66)), 1e-8);
}

TEST_P(EveryBaseline, TooFewAnchorsGiveTheAnswerNearestToTheShapeCarriedAlong) {
    const Mesh mesh = with_noise(sphere(2), 0.05, 1);
    for (Index count = 0; count <= 2; ++count) {
        std::vector<Index> anchors = spread_vertices(mesh, 3);
        anchors.resize(count);
        Positions targets = rows_of(mesh.vertices, anchors);
        targets.array() += 0.5;
        const double shift = count == 0 ? 0.0 : 0.5;
        const Positions deformed = deform(GetParam(), mesh, anchors, targets);
        EXPECT_LT(largest_distance(deformed, (mesh.vertices.array() + shift).matrix()), 1e-6) << count;
    }
}

TEST_P(EveryBaseline, DegenerateInputGivesFiniteNumbers) {
    for (Mesh mesh : all_classes()) {
        const std::vector<Index> anchors = spread_vertices(mesh, 3);
        EXPECT_TRUE(deform(GetParam(), mesh, anchors, Positions::Constant(3, 3, 0.25)).allFinite())
            << "collapsed targets, " << mesh.name;
        const Index middle = mesh.vertex_count() / 2;
        mesh.vertices.row(middle) = mesh.vertices.row(mesh.faces(0, 0));
        Positions targets = rows_of(mesh.vertices, anchors);
        targets.row(0).array() += 0.5;
        EXPECT_TRUE(deform(GetParam(), mesh, anchors, targets).allFinite()) << "coincident vertices, " << mesh.name;
        mesh.vertices.rightCols(2).setZero();
        targets = rows_of(mesh.vertices, anchors);
        targets.row(0).array() += 0.5;
        EXPECT_TRUE(deform(GetParam(), mesh, anchors, targets).allFinite()) << "all on a line, " << mesh.name;
        mesh.vertices.setZero();
        EXPECT_TRUE(deform(GetParam(), mesh, anchors, targets).allFinite()) << "all in a point, " << mesh.name;
    }
}

TEST_P(EveryBaseline, TrianglesThatFitNoManifoldDoNoHarm) {
    Mesh mesh = sphere(2);  // and a third triangle on an edge, and a duplicate
    mesh.faces.conservativeResize(mesh.faces.rows() + 2, 3);
    mesh.faces.row(mesh.faces.rows() - 2) << mesh.faces(0, 0), mesh.faces(0, 1), 60;
    mesh.faces.row(mesh.faces.rows() - 1) = mesh.faces.row(5);
    const std::vector<Index> anchors = {0, 1, 2};
    Positions targets = rows_of(mesh.vertices, anchors);
    EXPECT_LT(largest_distance(deform(GetParam(), mesh, anchors, targets), mesh.vertices), 1e-9);
    targets.row(0) *= 2.0;
    EXPECT_TRUE(deform(GetParam(), mesh, anchors, targets).allFinite());
}

TEST_P(EveryBaseline, NothingFreeIsSolvedAtOnce) {
    const Mesh mesh = triangle();
    EXPECT_EQ(deform(GetParam(), mesh, {0, 1, 2}, 2.0 * mesh.vertices), Positions(2.0 * mesh.vertices));
}

TEST_P(EveryBaseline, GivesTheSameBitsForAnyNumberOfThreads) {
    const Mesh mesh = with_noise(torus(80, 40), 0.05, 1);
    const std::vector<Index> anchors = spread_vertices(mesh, 8);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(3) += Eigen::RowVector3d(0.5, 0.5, 1.0);
    EXPECT_EQ(deform(GetParam(), mesh, anchors, targets, {}, 1), deform(GetParam(), mesh, anchors, targets, {}, 4));
}

TEST_P(EveryBaseline, CancelsAtAnyPlace) {
    const Mesh mesh = torus(40, 24);
    const std::vector<Index> anchors = spread_vertices(mesh, 4);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.row(1).array() += 0.5;
    int runs = 0;
    const std::vector<std::string> stages = cancelled_everywhere([&](Execution& execution) {
        ++runs;
        GetParam().deform({mesh.vertices, mesh.faces, anchors, targets, {}, 1}, execution);
    });
    EXPECT_EQ(stages.back(), "solve");
    EXPECT_GT(runs, 10);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryBaseline, testing::ValuesIn(all_methods()));

/// Largest distance to the shape moved as a whole, when all anchors are moved so; as a share of the diagonal.
double miss(const Baseline& method, const Mesh& mesh, double scale, double angle_deg) {
    const std::vector<Index> anchors = spread_vertices(mesh, 6);
    const Positions moved = moved_by_similarity(mesh.vertices, scale, {1, 2, 3}, angle_deg * kPi / 180, {5, -2, 1});
    return largest_distance(deform(method, mesh, anchors, rows_of(moved, anchors)), moved) / mesh.diagonal();
}

TEST(Laplacian, DoesNotTurnWithItsAnchors) {
    EXPECT_GT(miss(laplacian(), torus(24, 12), 1.0, 60.0), 0.01);
}

TEST(LaplacianSurfaceEditing, IsExactUnderScaleAndNearlyUnderSmallRotations) {
    const Mesh mesh = torus(24, 12);
    EXPECT_LT(miss(editing(1), mesh, 1.7, 0.0), 1e-9);
    EXPECT_LT(miss(editing(1), mesh, 1.0, 3.0), 1e-3);
    EXPECT_LT(miss(editing(1), mesh, 1.7, 3.0), 2e-3);
    EXPECT_LT(miss(editing(1), mesh, 1.0, 3.0), 0.1 * miss(laplacian(), mesh, 1.0, 3.0));
}

TEST(LaplacianSurfaceEditing, RoundsBringLargeRotationsNearer) {
    const Mesh mesh = torus(24, 12);
    const double once = miss(editing(1), mesh, 1.0, 40.0);
    EXPECT_LT(miss(editing(5), mesh, 1.0, 40.0), 0.5 * once);
    EXPECT_LT(miss(editing(20), mesh, 1.0, 40.0), 1e-3 * once);
}

TEST(Baselines, AreExactUnderRigidMotionAndPyramidCoordinatesUnderSimilarity) {
    for (const double angle_deg : {20.0, 120.0, 180.0}) {
        for (const Baseline& method : {pyramid(), arap(), rotation_invariant()}) {
            EXPECT_LT(miss(method, torus(24, 12), 1.0, angle_deg), 1e-9) << method.name;
            EXPECT_LT(miss(method, grid(9, 8, 0.05), 1.0, angle_deg), 1e-9) << method.name;
        }
        EXPECT_LT(miss(pyramid(), grid(9, 8, 0.05), 1.7, angle_deg), 1e-9);
    }
}

TEST(Pyramid, SweepsCarryOnUntilNothingMoves) {
    // Where the hierarchy leads is not yet what all rings together ask for.
    const Pose bend = bent_tube(0.5);
    const auto after = [&](int sweeps) {
        Execution execution;
        return baselines::pyramid(problem_of(bend), {sweeps}, execution);
    };
    const double diagonal = bend.mesh.diagonal();
    const double first_step = largest_distance(after(1), after(0)) / diagonal;
    EXPECT_GT(first_step, 1e-4);
    EXPECT_LT(largest_distance(after(1001), after(1000)) / diagonal, 0.05 * first_step);
    EXPECT_GT(largest_distance(after(1000), after(0)) / diagonal, 5.0 * first_step);
}

TEST(Arap, EnergyFallsInEachIterationUntilItsTolerance) {
    const auto energies_of = [](const Pose& pose, const baselines::ArapOptions& options) {
        Execution execution;
        std::vector<double> energies;
        baselines::arap(problem_of(pose), options, execution, &energies);
        return energies;
    };
    Pose bend = bent_tube(2.0);
    for (const double noise : {0.0, 0.2}) {
        bend.mesh = with_noise(bend.mesh, noise, 4);
        const std::vector<double> energies = energies_of(bend, {40, 1e-12});
        ASSERT_EQ(energies.size(), 41u);
        for (std::size_t k = 1; k < energies.size(); ++k)
            EXPECT_LT(energies[k], energies[k - 1]) << "iteration " << k;
        EXPECT_GT(energies.back(), 0.0);
    }
    EXPECT_LT(energies_of(bent_tube(0.5), {1000, 1e-3}).size(), 100u);
}

/// The two systems as they are in print: local frames and their differences along edges, then edges in these frames;
/// dense. @param frames 3n x 3, filled for what is fixed: F_i transposed. @param positions filled likewise.
void solve_as_in_print(const Mesh& mesh, const std::vector<char>& is_fixed, Eigen::MatrixXd& frames,
                       Positions& positions) {
    const Index count = mesh.vertex_count();
    std::vector<Matrix3> rest_frames(static_cast<std::size_t>(count));
    for (Index v = 0; v < count; ++v) {
        const Vector3 axis(std::sin(3.1 * v), std::cos(1.7 * v), 0.5);
        rest_frames[v] = Eigen::AngleAxisd(2.3 * v, axis.normalized()).toRotationMatrix();
    }
    std::vector<Index> free_lines;
    std::vector<Index> free;
    for (Index v = 0; v < count; ++v) {
        if (is_fixed[v]) continue;
        free.push_back(v);
        free_lines.insert(free_lines.end(), {3 * v, 3 * v + 1, 3 * v + 2});
    }
    const OneRings rings = rings_of(mesh);
    const auto edges = static_cast<Eigen::Index>(rings.vertices.size());
    Eigen::MatrixXd turn_rows = Eigen::MatrixXd::Zero(3 * edges, 3 * static_cast<Eigen::Index>(count));
    Eigen::MatrixXd edge_rows = Eigen::MatrixXd::Zero(edges, count);
    const auto for_each_edge = [&](const auto& visit) {
        for (Index i = 0, edge = 0; i < count; ++i) {
            for (const Index* j = rings.begin(i); j != rings.end(i); ++j)
                visit(edge++, i, *j);
        }
    };
    for_each_edge([&](Index edge, Index i, Index j) {
        turn_rows.block<3, 3>(3 * edge, 3 * j).setIdentity();
        turn_rows.block<3, 3>(3 * edge, 3 * i) = -rest_frames[j].transpose() * rest_frames[i];
        edge_rows(edge, j) = 1.0;
        edge_rows(edge, i) = -1.0;
    });
    for (Index v = 0; v < count; ++v)
        frames.middleRows<3>(3 * v) = rest_frames[v].transpose() * frames.middleRows<3>(3 * v);
    frames(free_lines, Eigen::all).setZero();
    frames(free_lines, Eigen::all) =
        -turn_rows(Eigen::all, free_lines).colPivHouseholderQr().solve(turn_rows * frames);
    Positions wanted(edges, 3);
    for_each_edge([&](Index edge, Index i, Index j) {
        const Matrix3 frame = fit_rotation(frames.middleRows<3>(3 * i).transpose());
        const Vector3 local = rest_frames[i].transpose() * Vector3(mesh.vertices.row(j) - mesh.vertices.row(i));
        wanted.row(edge) = (frame * local).transpose();
    });
    positions(free, Eigen::all).setZero();
    positions(free, Eigen::all) =
        edge_rows(Eigen::all, free).colPivHouseholderQr().solve(wanted - edge_rows * positions);
}

TEST(RotationInvariant, IsTheMethodAsInPrintWhicheverTheFrames) {
    const Mesh mesh = with_noise(torus(8, 6), 0.05, 2);
    // A triangle with a handle's turn, and another that stays.
    const Index far = mesh.faces(mesh.faces.rows() / 2, 0);
    std::vector<Index> anchors = {mesh.faces(0, 0), mesh.faces(0, 1), mesh.faces(0, 2)};
    for (int c = 0; c < 3; ++c)
        anchors.push_back(mesh.faces(mesh.faces.rows() / 2, c));
    const Matrix3 turn = Eigen::AngleAxisd(1.2, Vector3(1, 2, 2).normalized()).toRotationMatrix();
    const Vector3 centre = mesh.vertices.row(far);
    Positions positions = mesh.vertices;
    Eigen::MatrixXd frames = Matrix3::Identity().replicate(mesh.vertex_count(), 1);
    std::vector<char> is_fixed(mesh.vertex_count(), 0);
    for (std::size_t k = 0; k < anchors.size(); ++k) {
        const Index v = anchors[k];
        is_fixed[v] = 1;
        if (k < 3) continue;
        positions.row(v) = (centre + turn * (Vector3(mesh.vertices.row(v)) - centre)).transpose();
        frames.middleRows<3>(3 * v) = turn.transpose();
    }
    const Positions targets = rows_of(positions, anchors);
    solve_as_in_print(mesh, is_fixed, frames, positions);
    EXPECT_LT(largest_distance(deform(rotation_invariant(), mesh, anchors, targets), positions),
              1e-9 * mesh.diagonal());
}

TEST(RotationInvariant, TurnsDetailsWithAHandleWhichLaplacianCoordinatesDoNot) {
    const Pose bend = bent_tube(kPi / 2);
    const Encoding encoding = encoding_of(bend.mesh);
    Execution execution;
    const auto energy_of = [&](const Baseline& method) {
        return energy(encoding, deform(method, bend.mesh, bend.anchors, bend.targets), 1, execution);
    };
    EXPECT_LT(energy_of(rotation_invariant()), 0.1 * energy_of(laplacian()));
}

TEST(Baselines, MeanValueEnergyIsLowestForItsOwnMinimiserAndHighestForLaplacianCoordinates) {
    const Pose bend = bent_tube(kPi / 2);
    const Encoding encoding = encoding_of(bend.mesh);
    Execution execution;
    const auto full = bound(binding_of(bend.mesh, bend.anchors, meanvalue::Method::kFull));
    const double own = energy(encoding, solve(*full, bend.targets).vertices, 1, execution);
    std::vector<double> others;
    for (const Baseline& method : all_methods()) {
        const Positions deformed = deform(method, bend.mesh, bend.anchors, bend.targets);
        others.push_back(energy(encoding, deformed, 1, execution));
        EXPECT_LT(own, others.back()) << method.name;
    }
    for (std::size_t k = 1; k <= 3; ++k)
        EXPECT_LT(others[k], others[0]) << all_methods()[k].name;
}

}  // namespace
}  // namespace meanvalue::tests
