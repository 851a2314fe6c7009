#include <algorithm>
#include <cmath>
#include <memory>

#include "meanvalue/deform/deformer.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Without rigidity: shapes of any size are as good as each other.
std::unique_ptr<Deformer> bound_to(const Mesh& mesh, const std::vector<Index>& anchors, Method method) {
    return bound(binding_of(mesh, anchors, method, 1, 0.0));
}

class FarTargets : public testing::TestWithParam<Method> {
  protected:
    const Mesh mesh_ = with_noise(sphere(3), 0.05, 1);
    const std::vector<Index> anchors_ = spread_vertices(mesh_, 6);
    const Positions rest_ = rows_of(mesh_.vertices, anchors_);
    const std::unique_ptr<Deformer> deformer_ = bound_to(mesh_, anchors_, GetParam());
};

TEST_P(FarTargets, BeyondTheLimitAreRefusedByName) {
    for (const double diagonals : {1.01e6, 1e7, 1e10, 1e150, 1e300}) {
        Positions targets = rest_;
        targets(2, 1) -= diagonals * mesh_.diagonal();
        const std::string text = message_of<InvalidInput>([&] { solve(*deformer_, targets); });
        EXPECT_TRUE(contains(text, message("targets[2], of vertex ", anchors_[2], ", is "))) << text;
        EXPECT_TRUE(contains(text, "bounding-box diagonals of the mesh, and at most 1e+06")) << text;
        EXPECT_FALSE(contains(text, "inf")) << text;
    }
}

TEST_P(FarTargets, AStartBeyondTheLimitIsRefusedByName) {
    Positions start = mesh_.vertices;
    Index free = 0;
    while (std::count(anchors_.begin(), anchors_.end(), free) > 0)
        ++free;
    start(free, 0) = 1e9 * mesh_.diagonal();
    const std::string text = message_of<InvalidInput>([&] { solve_from(*deformer_, rest_, start); });
    EXPECT_TRUE(contains(text, message("start[", free, "] is"))) << text;
    // Fixed vertices are not taken from it.
    start = mesh_.vertices;
    start(anchors_[0], 0) = 1e9 * mesh_.diagonal();
    EXPECT_NO_THROW(solve_from(*deformer_, rest_, start));
}

TEST_P(FarTargets, BelowTheLimitASimilarityIsFollowedAndMayBeTheNextStart) {
    for (const double factor : {1e2, 1e4, 0.5e6}) {
        const Vector3 far = Vector3(0.3, -0.8, 0.5) * factor * mesh_.diagonal();
        for (const double scale : {1.0, 0.5 * factor}) {
            const Positions moved = moved_by_similarity(mesh_.vertices, scale, {1, 2, 3}, 1.0, far);
            const Solution solution = solve(*deformer_, rows_of(moved, anchors_));
            const double unit = scale * mesh_.diagonal();
            // What the digits of far coordinates leave.
            EXPECT_LT(largest_distance(solution.vertices, moved), 1e-6 * unit + 1e-13 * far.norm())
                << factor << " " << scale;
            EXPECT_TRUE(std::isfinite(solution.energy));
            EXPECT_NO_THROW(solve_from(*deformer_, rows_of(moved, anchors_), solution.vertices));
        }
    }
}

TEST_P(FarTargets, ThatMakeNoShapeAreNotCalledConvergedFarFromAMinimum) {
    // "paper" minimises the energy of its coarse level, which is tested with that.
    if (GetParam() == Method::kPaper) return;
    for (const double diagonals : {1.0, 30.0, 1e3, 1e5}) {
        srand(1);
        const Positions targets = rest_ + diagonals * mesh_.diagonal() * Positions::Random(6, 3);
        const Solution solution = solve(*deformer_, targets);
        for (const double energy : solution.energies)
            EXPECT_TRUE(std::isfinite(energy));
        if (!solution.converged) continue;
        const auto full = bound_to(mesh_, anchors_, Method::kFull);
        const Solution further = solve_from(*full, targets, solution.vertices, {1e-9});
        EXPECT_GT(further.energy, 0.95 * solution.energy) << diagonals;
    }
}

INSTANTIATE_TEST_SUITE_P(Methods, FarTargets, testing::Values(Method::kFast, Method::kPaper, Method::kFull));

TEST(FarTargetsOf, AMeshWithoutAnExtentHasNoNearAndFar) {
    Mesh mesh = sphere(1);
    mesh.vertices.setOnes();
    const auto deformer = bound_to(mesh, {0, 1, 2}, Method::kFast);
    EXPECT_TRUE(solve(*deformer, Positions::Constant(3, 3, 5.0)).vertices.allFinite());
}

}  // namespace
}  // namespace meanvalue::tests
