#include "meanvalue/paper/paper_decoder.h"

#include <cmath>

#include "meanvalue/deform/deformer.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/paper/gauss_newton_system.h"
#include "tests/fast_poses.h"

namespace meanvalue::tests {
namespace {

/// A tube bent by its upper end; of both ends four vertices are anchors.
Pose bent_tube() {
    Pose pose{"bend", capped_tube(16, 60, 18.0), {}, {}};
    for (const Index v : {0, 4, 8, 12})
        pose.anchors.insert(pose.anchors.end(), {v, 59 * 16 + v});
    pose.targets = rows_of(pose.mesh.vertices, pose.anchors);
    const Positions turned = moved_by_similarity(pose.mesh.vertices, 1.0, Vector3::UnitX(), 0.8, {0, 5, -1});
    for (std::size_t k = 1; k < pose.anchors.size(); k += 2)
        pose.targets.row(k) = turned.row(pose.anchors[k]);
    return pose;
}

TEST(PaperDecoder, ComesNearTheMinimumFromAbove) {
    const Pose bend = bent_tube();
    const auto deformer = bound(binding_of(bend.mesh, bend.anchors, Method::kPaper));
    const Solution paper = solve(*deformer, bend.targets);
    const Solution full = solve(*bound(binding_of(bend.mesh, bend.anchors, Method::kFull)), bend.targets);
    EXPECT_LT(paper.energy, paper.initial_energy);
    EXPECT_GE(paper.energy, full.energy * (1 - 1e-6));
    // Measured: 26 times. The rings at single-vertex anchors are what four sweeps do not bring to rest.
    EXPECT_LT(paper.energy, 40.0 * full.energy);
    EXPECT_TRUE(paper.converged);
    EXPECT_GT(paper.initial_gradient, 0.0);
    EXPECT_LT(paper.gradient, paper.initial_gradient);
    for (const char* stage : {"base", "split", "optimise", "relax"})
        EXPECT_EQ(paper.timings.count(stage), 1u);
    const std::vector<Index>& sizes = deformer->report().level_sizes;
    ASSERT_EQ(sizes.size(), 3u);
    EXPECT_EQ(sizes[0], bend.mesh.vertex_count() - 8);
    EXPECT_EQ(sizes[1], static_cast<Index>(std::ceil(0.03 * sizes[0])));
    EXPECT_LT(sizes[2], sizes[1]);
}

TEST(PaperDecoder, RefusesPositionsWhoseEnergyOverflows) {
    const Pose bend = bent_tube();
    Execution execution;
    Region region{{}, bend.mesh.vertices, bend.mesh.faces, std::vector<char>(bend.mesh.vertex_count(), 0)};
    for (Index v = 0; v < bend.mesh.vertex_count(); ++v)
        region.vertices.push_back(v);
    const auto shape = encode_shape(std::move(region), 1, execution);
    const std::vector<char> is_fixed = flags(bend.mesh.vertex_count(), bend.anchors);
    const PaperDecoder decoder({shape, is_fixed}, 1, execution);
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
    Positions positions = mesh.vertices;
    positions(9, 0) += 0.1;
    const Positions before = positions;
    relax(encoding, unknowns, 1, positions, Execution());
    EXPECT_EQ(positions, before);
}

TEST(GaussSeidel, SweepsLowerTheEnergyTowardsTheMinimum) {
    const Mesh mesh = with_noise(sphere(3), 0.1, 1);
    const Encoding encoding = encoding_of(mesh);
    const Unknowns unknowns = find_unknowns(encoding, flags(mesh.vertex_count(), {0, 1, 2, 3}));
    const Execution execution;
    Positions positions = with_noise(mesh, 0.1, 9).vertices;
    double energy = meanvalue::energy(encoding, positions, 1, execution);
    const double start = energy;
    for (int sweep = 0; sweep < 20; ++sweep) {
        relax(encoding, unknowns, 1, positions, execution);
        const double after = meanvalue::energy(encoding, positions, 1, execution);
        EXPECT_LT(after, energy * (1 + 1e-9)) << sweep;
        energy = after;
    }
    EXPECT_LT(energy, 0.1 * start);
}

}  // namespace
}  // namespace meanvalue::tests
