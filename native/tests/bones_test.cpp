// Bones and weights for a clip: planted ones are found again, joints stay closed, bits are the same.
#include <cmath>

#include "meanvalue/bones/fit_bones.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

constexpr Index kBones = 5, kFrames = 12;
constexpr double kLength = 10.0;

/// A tube along z and a chain of bones in it, each turned against the one below about two axes: a hinge
/// leaves its place along the axis open. Weights change within a short way.
struct Chain {
    Mesh mesh = capped_tube(24, 80, kLength);
    std::vector<Positions> frames;
    Armature armature;

    Chain() {
        armature.heads = armature.tails = Positions::Zero(kBones, 3);
        for (Index j = 0; j < kBones; ++j) {
            armature.heads(j, 2) = kLength * j / kBones;
            armature.tails(j, 2) = kLength * (j + 1) / kBones;
            armature.parents.push_back(j - 1);
        }
        for (Index f = 0; f < kFrames; ++f) {
            std::vector<Eigen::Affine3d> moved;
            for (Index j = 0; j < kBones; ++j) {
                const Vector3 axis = Vector3(std::sin(1.0 + j), std::cos(2.0 * j), 0.3).normalized();
                const Vector3 head = armature.heads.row(j);
                const Eigen::Affine3d turn =
                    Eigen::Translation3d(head) * Eigen::AngleAxisd(0.6 * std::sin(0.7 * f + 2.0 * j), axis) *
                    Eigen::AngleAxisd(0.4 * std::cos(0.9 * f + j), Vector3::UnitZ().cross(axis).normalized()) *
                    Eigen::Translation3d(-head);
                moved.push_back(j == 0 ? Eigen::Translation3d(0.1 * f, 0.0, 0.0) * turn : moved[j - 1] * turn);
                armature.transforms.emplace_back(moved[j].matrix());
            }
            frames.push_back(mesh.vertices);
            for (Index v = 0; v < mesh.vertex_count(); ++v) {
                const Vector3 place = mesh.vertices.row(v);
                const double along = std::clamp(place.z() / kLength * kBones, 0.0, kBones - 1e-6);
                const auto bone = static_cast<Index>(along);
                const double part = std::clamp(5.0 * (along - bone), 0.0, 1.0);  // of the bone; else of the one below
                frames[f].row(v) =
                    part * (moved[bone] * place) + (1.0 - part) * (moved[std::max(0, bone - 1)] * place);
            }
        }
    }

    BoneFit fit(const BoneOptions& options) const {
        BoneClip clip(share(mesh.vertices, "rest"), kFrames, mesh.faces);
        for (Index f = 0; f < kFrames; ++f)
            clip.set_frame(f, frames[f]);
        Execution execution;
        return fit_bones(clip, options, execution);
    }

    double error_of(const BoneFit& found) const {
        return std::sqrt(found.errors.cast<double>().squaredNorm() / found.errors.size()) / mesh.diagonal();
    }
};

Vector3 placed(const Armature& armature, Index frame, Index bone, const Vector3& place) {
    const Transform& moved = armature.transforms[frame * armature.parents.size() + bone];
    return (moved * place.homogeneous()).head<3>();
}

TEST(Bones, ArePlantedAndFound) {
    const Chain chain;
    BoneOptions options;
    options.count = kBones;
    const BoneFit found = chain.fit(options);
    EXPECT_LT(chain.error_of(found), 2e-3);
    for (Index planted = 1; planted < kBones; ++planted) {
        const auto off = (found.armature.heads.rowwise() - chain.armature.heads.row(planted)).rowwise().norm();
        EXPECT_LT(off.tail(kBones - 1).minCoeff(), 0.01 * chain.mesh.diagonal()) << "joint " << planted;
    }
}

TEST(Bones, HaveClosedJointsAndFewWeightsOfSumOneThatMakeTheErrorsTold) {
    const Chain chain;
    BoneOptions options;
    options.count = 7;
    options.influences = 2;
    const BoneFit found = chain.fit(options);
    EXPECT_GE(found.weights.minCoeff(), 0.0);
    EXPECT_LT((found.weights.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-12);
    EXPECT_LE((found.weights.array() > 0.0).cast<int>().rowwise().sum().maxCoeff(), 2);
    const Armature& armature = found.armature;
    for (Index j = 1; j < 7; ++j) {
        ASSERT_LT(armature.parents[j], j);
        const Vector3 head = armature.heads.row(j);
        for (Index f = 0; f < kFrames; ++f)
            EXPECT_LT((placed(armature, f, j, head) - placed(armature, f, armature.parents[j], head)).norm(), 1e-9);
    }
    for (const Index v : {0, 500, 1500}) {
        Vector3 sum = -chain.frames[3].row(v).transpose();
        for (Index j = 0; j < 7; ++j)
            sum += found.weights(v, j) * placed(armature, 3, j, chain.mesh.vertices.row(v));
        EXPECT_NEAR(sum.norm(), found.errors(3, v), 1e-5);
    }
}

TEST(Bones, OfAnArmatureAreMovedOrGiveWeightsAlone) {
    const Chain chain;
    BoneOptions options;
    options.armature = chain.armature;
    EXPECT_LT(chain.error_of(chain.fit(options)), 1e-4);  // its own motion
    options.armature.transforms.clear();
    const BoneFit found = chain.fit(options);
    EXPECT_LT(chain.error_of(found), 2e-3);
    EXPECT_EQ(found.armature.heads, chain.armature.heads);
}

TEST(Bones, AreAsManyAsAnErrorTakes) {
    const Chain chain;
    BoneOptions options;
    options.joints = false;
    options.error = 0.02 * chain.mesh.diagonal();
    const BoneFit found = chain.fit(options);
    EXPECT_LE(chain.error_of(found), 0.02);
    options.error = 0.0;
    options.count = static_cast<Index>(found.armature.parents.size()) / 2;
    EXPECT_GT(chain.error_of(chain.fit(options)), 0.02);
}

TEST(Bones, HaveTheSameBitsForAnyNumberOfThreads) {
    const Chain chain;
    BoneOptions options;
    options.threads = 1;
    const BoneFit one = chain.fit(options);
    for (const int threads : {2, 3}) {
        options.threads = threads;
        const BoneFit more = chain.fit(options);
        EXPECT_EQ(one.weights, more.weights);
        EXPECT_EQ(one.errors, more.errors);
        EXPECT_EQ(one.armature.heads, more.armature.heads);
    }
}

TEST(Bones, OfAStaticClipIsOneAndExact) {
    Chain chain;
    for (Positions& frame : chain.frames)
        frame = moved_by_similarity(chain.mesh.vertices, 1.0, Vector3::UnitX(), 0.5, Vector3(1e5, 0.0, 0.0));
    const BoneFit found = chain.fit({});
    EXPECT_EQ(found.weights.cols(), 1);
    EXPECT_LT(found.errors.maxCoeff(), 1e-5);
}

TEST(Bones, AreCancelledAnywhere) {
    const Chain chain;
    BoneClip clip(share(chain.mesh.vertices, "rest"), kFrames, chain.mesh.faces);
    for (const std::int64_t check : {1, 30, 300}) {
        Execution execution;
        execution.cancel_at_check(check);
        for (Index f = 0; f < kFrames; ++f)
            clip.set_frame(f, chain.frames[f]);
        EXPECT_THROW(fit_bones(clip, {}, execution), Cancelled);
    }
}

TEST(Bones, RefuseBadInputByName) {
    Chain chain;
    const auto refusal = [&](const BoneOptions& options) -> std::string {
        try {
            chain.fit(options);
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    BoneOptions options;
    options.count = 0;
    EXPECT_NE(refusal(options).find("count is 0"), std::string::npos);
    options.count = 5;
    options.armature = chain.armature;
    options.armature.parents[2] = 3;
    EXPECT_NE(refusal(options).find("parents[2] is 3"), std::string::npos);
    options.armature = chain.armature;
    options.armature.transforms[2 * chain.armature.parents.size() + 1].topLeftCorner<3, 3>() *= 1.1;
    EXPECT_NE(refusal(options).find("transforms[2, 1] is no turn"), std::string::npos);
    options.armature = chain.armature;
    options.armature.transforms[3 * chain.armature.parents.size()](1, 3) = std::nan("");
    EXPECT_NE(refusal(options).find("transforms[3, 0] is no turn"), std::string::npos);
    chain.frames[7](3, 1) = std::nan("");
    EXPECT_NE(refusal({}).find("frames[7][3]"), std::string::npos);
}

}  // namespace
}  // namespace meanvalue::tests
