#include <gtest/gtest.h>

#include <numeric>

#include "meanvalue/common/errors.h"
#include "meanvalue/deform/binding_input.h"
#include "meanvalue/deform/deformer.h"
#include "meshes.h"
#include "support.h"

namespace meanvalue::tests {
namespace {

constexpr double kLength = 12.0;

/// A tube whose upper half is bent about x, within `reach` of the middle: a limb with an elbow.
Positions bent_tube(const Mesh& tube, double angle_rad, double reach) {
    Positions bent = tube.vertices;
    for (Index v = 0; v < tube.vertex_count(); ++v) {
        const double z = tube.vertices(v, 2) - kLength / 2.0;
        const double share = std::min(std::max(0.5 + 0.5 * z / reach, 0.0), 1.0);
        const Matrix3 rotation = Eigen::AngleAxisd(share * angle_rad, Vector3::UnitX()).toRotationMatrix();
        bent.row(v) = (rotation * Vector3(bent(v, 0), bent(v, 1), z)).transpose();
        bent(v, 2) += kLength / 2.0;
    }
    return bent;
}

struct Limb {
    Mesh tube = capped_tube(24, 60, kLength);
    std::vector<Index> anchors = spread_vertices(tube, 8);

    Binding binding(const std::vector<double>& example_angles_rad) const {
        Binding binding(tube.vertices, tube.faces, anchors);
        for (const double angle : example_angles_rad)
            binding.examples.push_back(share(bent_tube(tube, angle, 0.5), "example"));
        return binding;
    }
    Positions targets(double angle_rad) const { return bent_tube(tube, angle_rad, 0.5)(anchors, Eigen::all); }
    double error(const Solution& solution, double angle_rad) const {
        return (solution.vertices - bent_tube(tube, angle_rad, 0.5)).norm();
    }
};

TEST(Examples, ALimbBendsWhereTheyBend) {
    const Limb limb;
    const Solution alone = Deformer(limb.binding({})).solve(limb.targets(0.9));
    const Solution taught = Deformer(limb.binding({1.5, 0.4})).solve(limb.targets(0.9));
    EXPECT_TRUE(alone.example_weights.empty());
    EXPECT_LT(limb.error(taught, 0.9), 0.5 * limb.error(alone, 0.9));
    ASSERT_EQ(taught.example_weights.size(), 3u * limb.tube.vertex_count());
    for (std::size_t k = 0; k < taught.example_weights.size(); k += 3)
        EXPECT_NEAR(taught.example_weights[k] + taught.example_weights[k + 1] + taught.example_weights[k + 2], 1.0,
                    1e-9);
}

TEST(Examples, BitsDoNotDependOnThreads) {
    const Limb limb;
    std::vector<Solution> solutions;
    for (const int threads : {1, 2, 3}) {
        Binding binding = limb.binding({1.5});
        binding.threads = threads;
        solutions.push_back(Deformer(binding).solve(limb.targets(0.9)));
    }
    for (const Solution& other : solutions) {
        EXPECT_EQ(other.vertices, solutions.front().vertices);
        EXPECT_EQ(other.example_weights, solutions.front().example_weights);
    }
}

TEST(Examples, WhereTheyAreDoesNotMatter) {
    const Limb limb;
    const Solution there = Deformer(limb.binding({1.5})).solve(limb.targets(0.9));
    Binding moved = limb.binding({});
    moved.examples.push_back(share(
        moved_by_similarity(bent_tube(limb.tube, 1.5, 0.5), 1.0, {1.0, 2.0, 3.0}, 2.0, {5.0, 6.0, 7.0}), "moved"));
    const Solution here = Deformer(moved).solve(limb.targets(0.9));
    EXPECT_LT((here.vertices - there.vertices).norm(), 1e-3 * limb.tube.diagonal());
}

TEST(Examples, ADragEndsWhereASolveDoes) {
    const Limb limb;
    const Deformer deformer(limb.binding({1.5, 0.4}));
    Deformer::Drag drag(deformer);
    Execution execution;
    for (int frame = 0; frame <= 20; ++frame)
        drag.solve(limb.targets(0.9 * frame / 20), {}, execution);
    for (int frame = 0; frame < 20; ++frame)
        drag.solve(limb.targets(0.9), {}, execution);
    const Solution dragged = drag.solve(limb.targets(0.9), {}, execution);
    const Solution alone = Deformer(limb.binding({})).solve(limb.targets(0.9));
    EXPECT_LT(limb.error(dragged, 0.9), 0.6 * limb.error(alone, 0.9));
}

TEST(Examples, ASolveFromAShapeDependsOnNothingSolvedBefore) {
    const Limb limb;
    const Deformer deformer(limb.binding({1.5, 0.4}));
    const Positions start = Deformer(limb.binding({1.5, 0.4})).solve(limb.targets(0.9)).vertices;
    const Solution first = solve_from(deformer, limb.targets(0.9), start);
    const Solution again = solve_from(deformer, limb.targets(0.9), start);
    EXPECT_EQ(again.vertices, first.vertices);
    EXPECT_EQ(again.example_weights, first.example_weights);
}

TEST(Examples, BindingAgainIsBindingAtFirst) {
    const Limb limb;
    const Deformer first(limb.binding({1.5}));
    Binding again = first.binding_again();
    again.anchors = spread_vertices(limb.tube, 5);
    Execution execution;
    const Deformer second(again, execution, &first);
    Binding fresh = limb.binding({1.5});
    fresh.anchors = again.anchors;
    const Positions targets = bent_tube(limb.tube, 0.9, 0.5)(fresh.anchors, Eigen::all);
    EXPECT_EQ(second.solve(targets).vertices, Deformer(fresh).solve(targets).vertices);
}

TEST(Examples, WhereNothingIsFreeTheRestShapeCountsAll) {
    const Limb limb;
    const Positions bent = bent_tube(limb.tube, 0.4, 0.5);
    Binding anchored = limb.binding({1.5});
    anchored.anchors.resize(limb.tube.vertex_count());
    std::iota(anchored.anchors.begin(), anchored.anchors.end(), 0);
    EXPECT_EQ(Deformer(anchored).solve(bent).vertices, bent);
    Binding outside = limb.binding({1.5});
    outside.roi.emplace(limb.tube.vertex_count(), char{0});
    const Solution solution = Deformer(outside).solve(limb.targets(0.0));
    EXPECT_EQ(solution.vertices, limb.tube.vertices);
    EXPECT_EQ(solution.example_weights.size(), 2u * limb.tube.vertex_count());
    Binding without_anchors = limb.binding({1.5});
    without_anchors.anchors.clear();
    EXPECT_EQ(Deformer(without_anchors).solve(Positions(0, 3)).vertices, limb.tube.vertices);
    Binding empty(Positions(0, 3), Triangles(0, 3), {});
    empty.examples.push_back(share(Positions(0, 3), "example"));
    EXPECT_THROW(Deformer{empty}, InvalidInput);
}

TEST(Examples, BindingAgainToOthersIsRefused) {
    const Limb limb;
    const Deformer first(limb.binding({1.5}));
    Execution execution;
    for (const std::vector<double>& angles : {std::vector<double>{}, {0.4}, {1.5, 0.4}})
        EXPECT_THROW(Deformer(limb.binding(angles), execution, &first), InvalidInput);
    EXPECT_NO_THROW(Deformer(limb.binding({1.5}), execution, &first));
}

TEST(Examples, FoldedCellsGiveFiniteShapes) {
    const Limb limb;
    Binding binding = limb.binding({1.5});
    Positions folded = bent_tube(limb.tube, 0.4, 0.5);
    for (Index v = 100; v < 200; ++v)
        folded.row(v) = folded.row(100);
    binding.examples.push_back(share(folded, "folded"));
    EXPECT_TRUE(Deformer(binding).solve(limb.targets(0.9)).vertices.allFinite());
}

TEST(Examples, WhatIsWrongIsNamed) {
    const Limb limb;
    const auto refusal = [&](const Positions& example, Method method = Method::kFast) -> std::string {
        Binding binding = limb.binding({1.5});
        binding.examples.push_back(share(example, "example"));
        binding.method = method;
        try {
            Deformer{binding};
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "nothing";
    };
    const Positions bent = bent_tube(limb.tube, 0.4, 0.5);
    Positions mirrored = bent;
    mirrored.col(0) *= -1.0;
    Positions broken = bent;
    broken(3, 1) = std::numeric_limits<double>::quiet_NaN();
    const auto moved = [](const Positions& shape) {
        return moved_by_similarity(shape, 1.0, {1.0, 2.0, 3.0}, 2.0, {5.0, 6.0, 7.0});
    };
    EXPECT_EQ(refusal(bent), "nothing");
    EXPECT_NE(refusal(bent, Method::kPaper).find("only method 'fast'"), std::string::npos);
    EXPECT_NE(refusal(Positions(bent.topRows(9))).find("examples[1] has 9 vertices"), std::string::npos);
    EXPECT_NE(refusal(Positions(100.0 * bent)).find("examples[1] is 100"), std::string::npos);
    EXPECT_NE(refusal(mirrored).find("mirrored"), std::string::npos);
    EXPECT_NE(refusal(broken).find("examples[1][3]"), std::string::npos);
    EXPECT_NE(refusal(moved(limb.tube.vertices)).find("examples[1] is the rest shape"), std::string::npos);
    EXPECT_NE(refusal(moved(bent_tube(limb.tube, 1.5, 0.5))).find("the same shape as examples[0]"),
              std::string::npos);
}

}  // namespace
}  // namespace meanvalue::tests
