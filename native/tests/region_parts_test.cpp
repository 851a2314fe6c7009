// What is solved has the bits that it has alone, whatever stands beside it.
#include <cmath>
#include <functional>
#include <limits>

#include "meanvalue/common/errors.h"
#include "meanvalue/deform/bound_mesh.h"
#include "meanvalue/sequence/sequence.h"
#include "tests/fast_poses.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Motion = std::function<Positions(double time)>;

struct Actor {
    Mesh mesh;
    std::vector<Index> anchors;
    Motion targets;
};

Actor bending(const Mesh& mesh, double angle_rad) {
    return {mesh, bend("", mesh, 1.0).anchors,
            [=](double time) { return bend("", mesh, 1e-3 + angle_rad * time).targets; }};
}

Actor still(Mesh mesh, std::vector<Index> anchors, double away) {
    mesh.vertices.col(0).array() += away;
    const Positions targets = rows_of(mesh.vertices, anchors);
    return {mesh, std::move(anchors), [=](double) { return Positions(targets); }};
}

/// A tube that is twisted until it snaps.
Actor twisting(const Mesh& mesh, double angle_rad) {
    const auto twist = [=](double angle) { return two_ends("", mesh, Vector3::UnitZ(), angle, {0, 0, 0}); };
    return {mesh, twist(0.0).anchors, [=](double time) { return twist(angle_rad * time).targets; }};
}

/// An actor, and another beside it, whose vertices come behind or before.
struct Stage {
    Mesh mesh;
    std::vector<Index> anchors;
    Motion targets;
    Index first = 0;  // vertex of the actor
    Index count;

    explicit Stage(const Actor& actor)
        : mesh(actor.mesh), anchors(actor.anchors), targets(actor.targets), count(mesh.vertex_count()) {}
    Stage(const Actor& actor, const Actor& other, bool is_behind) : Stage(actor) {
        const Actor& a = is_behind ? actor : other;
        const Actor& b = is_behind ? other : actor;
        mesh = joined(a.mesh, b.mesh);
        anchors = a.anchors;
        for (const Index v : b.anchors)
            anchors.push_back(a.mesh.vertex_count() + v);
        if (!is_behind) first = other.mesh.vertex_count();
        targets = [=](double time) {
            Positions all(static_cast<Eigen::Index>(a.anchors.size() + b.anchors.size()), 3);
            all << a.targets(time), b.targets(time);
            return all;
        };
    }

    Positions of_actor(const Positions& whole) const { return whole.middleRows(first, count); }

    /// What the actor does in a cold solve, in a drag, as a draft, at the end of the drag, and in a clip.
    std::vector<Positions> run(const Deformer& deformer) const {
        std::vector<Positions> shapes = {of_actor(solve(deformer, targets(0.7)).vertices)};
        Deformer::Drag drag(deformer);
        SolveOptions options;
        for (const double time : {0.1, 0.2, 0.25, 0.3, 0.35}) {
            const auto draft = drag.draft(targets(time));
            if (time > 0.25 && draft) shapes.push_back(of_actor(*draft));
            options.settle = time == 0.35;
            shapes.push_back(of_actor(solve_next(drag, targets(time), options).vertices));
        }
        const Sequence clip = solve_clip(deformer);
        for (Index frame = 0; frame < clip.frame_count; ++frame) {
            using Frame = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;
            shapes.push_back(of_actor(
                Frame(clip.vertices.get() + std::ptrdiff_t{3} * frame * clip.vertex_count, clip.vertex_count, 3)
                    .cast<double>()));
        }
        return shapes;
    }

    Sequence solve_clip(const Deformer& deformer) const {
        Trajectories trajectories;
        trajectories.frame_count = 24;
        trajectories.anchor_count = static_cast<Index>(anchors.size());
        for (Index frame = 0; frame < trajectories.frame_count; ++frame) {
            const Positions all = targets(frame / 24.0);
            trajectories.targets.insert(trajectories.targets.end(), all.data(), all.data() + all.size());
        }
        SequenceOptions options;
        options.chunk = 16;
        options.overlap = 4;
        Execution execution;
        return solve_sequence(deformer, trajectories, options, execution);
    }
};

void expect_same(const std::vector<Positions>& shapes, const std::vector<Positions>& alone) {
    ASSERT_EQ(shapes.size(), alone.size());
    for (std::size_t k = 0; k < shapes.size(); ++k)
        EXPECT_EQ(shapes[k], alone[k]) << "shape " << k << ": " << largest_distance(shapes[k], alone[k]);
}

std::vector<Actor> others(const Mesh& mesh) {
    return {still(random_fan(4, 1), {0, 1}, 1.5 * mesh.diagonal()),
            still(random_fan(4, 1), {0}, 30 * mesh.diagonal()), still(mesh, bend("", mesh, 1.0).anchors, 8.0),
            bending(with_noise(mesh, 0.1, 3), 2.5)};
}

TEST(RegionParts, HaveTheBitsThatTheyHaveAlone) {
    for (const Method method : {Method::kFast, Method::kPaper, Method::kFull}) {
        const Mesh mesh = method == Method::kFast ? capped_tube(40, 60, 8.0) : capped_tube(12, 25, 8.0);
        const Actor actor = bending(mesh, 1.5);
        const Stage alone(actor);
        const std::vector<Positions> expected = alone.run(*bound(binding_of(mesh, alone.anchors, method)));
        for (const Actor& other : others(mesh)) {
            for (const bool is_behind : {true, false}) {
                if (!is_behind && method != Method::kFast) continue;
                const Stage stage(actor, other, is_behind);
                const auto deformer = bound(binding_of(stage.mesh, stage.anchors, method));
                EXPECT_EQ(deformer->bound().parts().size(), 2u);
                expect_same(stage.run(*deformer), expected);
            }
        }
    }
}

TEST(RegionParts, SpreadOnlyTheirOwnSnaps) {
    const Actor actor = bending(capped_tube(12, 25, 8.0), 1.5);
    const Stage alone(actor);
    const Stage stage(actor, twisting(actor.mesh, 12.0), true);
    const auto deformer = bound(binding_of(stage.mesh, stage.anchors));
    EXPECT_FALSE(stage.solve_clip(*deformer).snaps.empty());
    expect_same(stage.run(*deformer), alone.run(*bound(binding_of(alone.mesh, alone.anchors))));
}

TEST(RegionParts, AreWhatMayMoveAndHangsTogether) {
    const Mesh mesh = bar(6, 60);
    const auto limb = [&](bool has_other) {
        Pose pose = bend("", mesh, 0.4);
        Binding binding = binding_of(mesh, pose.anchors);
        binding.roi.emplace(mesh.vertex_count(), 0);
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const double z = mesh.vertices(v, 2) / mesh.vertices.col(2).maxCoeff();
            (*binding.roi)[v] = static_cast<char>(z > 0.6 || (has_other && z < 0.4));
        }
        const auto deformer = bound(binding);
        EXPECT_EQ(deformer->bound().parts().size(), has_other ? 2u : 1u);
        return solve(*deformer, pose.targets).vertices;
    };
    const Positions one = limb(false);
    const Positions two = limb(true);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertices(v, 2) > 0.5 * mesh.vertices.col(2).maxCoeff()) {
            EXPECT_EQ(one.row(v), two.row(v)) << v;
        }
}

TEST(RegionParts, KeepTheirBitsWithSoftAnchorsWeightsAndExamples) {
    const Mesh mesh = capped_tube(24, 40, 8.0);
    const Actor actor = bending(mesh, 1.0);
    const auto run = [&](const Stage& stage, bool has_other) {
        Binding binding = binding_of(stage.mesh, stage.anchors);
        binding.strengths.assign(stage.anchors.size(), 20.0);
        const Stage example =
            has_other ? Stage(bending(mesh, 0.9), bending(mesh, 0.4), true) : Stage(bending(mesh, 0.9));
        const auto shape = bound(binding_of(stage.mesh, stage.anchors));
        binding.examples.push_back(share(solve(*shape, example.targets(1.0)).vertices, "example"));
        SolveOptions options;
        if (has_other) {  // given for the other one's sake
            options.weights.assign(stage.anchors.size(), 1.0);
            options.weights.back() = 0.5;
        }
        const auto deformer = bound(binding);
        std::vector<Positions> shapes;
        Deformer::Drag drag(*deformer);
        for (const double time : {0.1, 0.2, 0.3}) {
            const Solution solution = solve_next(drag, stage.targets(time), options);
            shapes.push_back(stage.of_actor(solution.vertices));
            EXPECT_EQ(solution.example_weights.size(), std::size_t{2} * stage.mesh.vertex_count());
        }
        return shapes;
    };
    expect_same(run(Stage(actor, bending(mesh, 0.5), true), true), run(Stage(actor), false));
}

/// A pinned piece that has nothing free, and a point that a spring pulls.
Mesh with_pieces(const Mesh& mesh) {
    Mesh point;
    point.vertices = Positions::Constant(1, 3, 20.0);
    point.faces.resize(0, 3);
    return joined(joined(mesh, still(random_fan(4, 1), {}, 9.0).mesh), point);
}

TEST(RegionParts, PiecesAndPointsBesideTakeNoDraftAndTellNoSnap) {
    const Actor actor = bending(capped_tube(24, 40, 8.0), 0.8);
    const Stage alone(actor);
    const std::vector<Positions> expected = alone.run(*bound(binding_of(alone.mesh, alone.anchors)));
    Stage stage(actor);
    stage.mesh = with_pieces(actor.mesh);
    for (Index v = stage.count; v < stage.mesh.vertex_count(); ++v)
        stage.anchors.push_back(v);
    const auto places =
        rows_of(stage.mesh.vertices, {stage.anchors.begin() + alone.anchors.size(), stage.anchors.end()});
    stage.targets = [&](double time) {
        Positions all(static_cast<Eigen::Index>(stage.anchors.size()), 3);
        all << actor.targets(time), places;
        all(all.rows() - 1, 0) += std::sin(5.0 * time) + 0.1 / 3.0;
        return all;
    };
    Binding binding = binding_of(stage.mesh, stage.anchors);
    binding.strengths.assign(stage.anchors.size(), std::numeric_limits<double>::infinity());
    binding.strengths.back() = 10.0;
    const auto deformer = bound(binding);
    expect_same(stage.run(*deformer), expected);
    EXPECT_TRUE(stage.solve_clip(*deformer).snaps.empty());
    EXPECT_TRUE(solve(*deformer, stage.targets(0.5)).converged);
}

TEST(RegionParts, EnoughEnergiesAreOneForEach) {
    const Stage stage(bending(capped_tube(12, 20, 8.0), 1.0), bending(capped_tube(12, 20, 8.0), 0.5), true);
    const auto deformer = bound(binding_of(stage.mesh, stage.anchors));
    SolveOptions options;
    options.enough_energies = solve(*deformer, stage.targets(0.2)).part_energies;
    EXPECT_EQ(options.enough_energies.size(), 2u);
    EXPECT_NO_THROW(solve_from(*deformer, stage.targets(0.2), stage.mesh.vertices, options));
    options.enough_energies.push_back(1.0);
    EXPECT_THROW(solve_from(*deformer, stage.targets(0.2), stage.mesh.vertices, options), InvalidInput);
}

TEST(RegionParts, AFrameThatIsCancelledAnywhereLeavesAllOfThemWhereTheyWere) {
    const Mesh mesh = capped_tube(12, 20, 8.0);
    const Stage stage(bending(mesh, 1.0), bending(mesh, 0.5), true);
    const auto deformer = bound(binding_of(stage.mesh, stage.anchors));
    Deformer::Drag drag(*deformer);
    solve_next(drag, stage.targets(0.1));
    const Positions before = solve_next(drag, stage.targets(0.2)).vertices;
    SolveOptions none;
    none.max_iterations = 0;
    cancelled_everywhere([&](Execution& execution) {
        EXPECT_EQ(solve_next(drag, stage.targets(0.2), none).vertices, before);
        drag.solve(stage.targets(0.4), {}, execution);
    });
}

TEST(RegionParts, ProgressNeverRunsBack) {
    const Stage stage(bending(capped_tube(40, 60, 8.0), 1.0), bending(capped_tube(12, 20, 8.0), 0.5), true);
    std::vector<std::string> stages;
    double last = 0.0;
    double most_of_solve = 0.0;
    const auto look = [&](const Execution& execution) {
        if (stages.empty() || stages.back() != execution.stage()) {
            stages.emplace_back(execution.stage());
            last = 0.0;
        }
        EXPECT_GE(execution.progress(), last) << stages.back();
        last = execution.progress();
        if (stages.back() == "solve") most_of_solve = last;
    };
    for (std::int64_t check = 1;; check += 1 + check / 16) {
        Execution execution;
        execution.cancel_at_check(check);
        try {
            const Deformer deformer(binding_of(stage.mesh, stage.anchors, Method::kFast, 1), execution);
            deformer.solve(stage.targets(0.9), {}, {}, execution);
            EXPECT_EQ(execution.progress(), 1.0);
            break;
        } catch (const Cancelled&) {
            look(execution);
        }
    }
    EXPECT_EQ(stages, (std::vector<std::string>{"", "encode", "factor", "solve"}));
    EXPECT_GT(most_of_solve, 0.8);  // the large one is solved first
}

TEST(RegionParts, ManySmallOnesAreSolvedSideBySide) {
    Mesh mesh = strip();
    std::vector<Index> anchors = {0};
    while (mesh.vertex_count() < 2000) {
        Mesh other = mesh;
        other.vertices.col(1).array() += 3.0 * mesh.vertex_count();
        mesh = joined(mesh, other);
    }
    for (Index v = strip().vertex_count(); v < mesh.vertex_count(); v += strip().vertex_count())
        anchors.push_back(v);
    Positions targets = rows_of(mesh.vertices, anchors);
    targets.col(2).array() += 1.0;
    const auto deformer = bound(binding_of(mesh, anchors, Method::kFast, 2));
    EXPECT_EQ(deformer->bound().parts().size(), anchors.size());
    const Solution solution = solve(*deformer, targets);
    EXPECT_TRUE(solution.converged);
    EXPECT_LT(largest_distance(solution.vertices,
                               moved_by_similarity(mesh.vertices, 1.0, Vector3::UnitX(), 0.0, Vector3::UnitZ())),
              1e-3);
}

}  // namespace
}  // namespace meanvalue::tests
