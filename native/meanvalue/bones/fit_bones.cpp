#include "meanvalue/bones/fit_bones.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "meanvalue/bones/skin.h"
#include "meanvalue/common/checks.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/same_places.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue {
namespace {

constexpr Index kSampledVertices = 5000;              // that bones are found by
constexpr Index kFreeRounds = 40, kJointRounds = 60;  // of the sample
constexpr Index kWholeRounds = 6, kGivenRounds = 10;
constexpr Index kSampleSweeps = 8, kSweeps = 12;
constexpr Index kMostBones = 256, kMostInfluences = 8;
constexpr int kMostSearches = 5;
constexpr double kCloseEnough = 0.9, kAimedAt = 0.95;   // of the error asked for
constexpr double kShortest = 0.03, kLongest = 0.3;      // bones, of the diagonal
constexpr double kRigid = 1e-3;                         // so near are given turns to such
constexpr float kTogether = 1e-5F, kMostGrowth = 1e4F;  // of the size

class BoneFitting {
  public:
    BoneFitting(const BoneClip& clip, const BoneOptions& options, Execution& execution)
        : clip_(clip), options_(options), execution_(execution), skin_(clip.frames) {
        skin_.influences = options.influences;
        skin_.threads = thread_count(options.threads);
        skin_.rest = placed(*clip.rest).transpose().colwise().homogeneous();
        look_around();
    }

    BoneFit fit() {
        if (!options_.armature.parents.empty())
            take_armature();
        else if (options_.error > 0.0)
            search();
        else
            find(options_.count);
        return result();
    }

  private:
    Positions placed(const Positions& points) const {
        return (points.rowwise() - clip_.center.transpose()) / clip_.size;
    }

    void look_around() {
        const std::vector<Index> corners(clip_.faces.data(), clip_.faces.data() + clip_.faces.size());
        std::vector<Index> starts(clip_.faces.rows());
        for (std::size_t f = 0; f < starts.size(); ++f)
            starts[f] = static_cast<Index>(3 * f);
        skin_.first = first_of_seams(*clip_.rest, corners, starts, 0.0, execution_);
        for (Index v = 0; v < skin_.vertex_count(); ++v)
            if ((skin_.frames.col(v) - skin_.frames.col(skin_.first[v])).cwiseAbs().maxCoeff() > kTogether)
                skin_.first[v] = v;
        skin_.around = grouped<Index>(skin_.vertex_count(), [&](const auto& add) {
            for (std::size_t k = 0; k < corners.size(); ++k)
                for (const std::size_t other : {k - k % 3 + (k + 1) % 3, k - k % 3 + (k + 2) % 3})
                    add(skin_.first[corners[k]], skin_.first[corners[other]]);
        });
    }

    void alternate(Skin& skin, Index rounds, Index sweeps, double done, double part) {
        for (Index round = 1; round <= rounds; ++round) {
            if (options_.armature.transforms.empty()) fit_motion(skin, sweeps, execution_);
            fit_weights(skin, execution_);
            execution_.set_progress(done_ + part_ * (done + part * round / rounds));
        }
    }

    void find(Index count) {
        const auto sampled = Eigen::seq(0, skin_.vertex_count() - 1, 1 + skin_.vertex_count() / kSampledVertices);
        const Eigen::MatrixXf frames = skin_.frames(Eigen::all, sampled);
        Skin sample(frames);
        sample.rest = skin_.rest(Eigen::all, sampled);
        sample.first.resize(sampled.size());
        std::iota(sample.first.begin(), sample.first.end(), 0);
        sample.threads = skin_.threads;
        sample.around = grouped<Index>(sample.vertex_count(), [](const auto&) {});
        split_bones(sample, count, execution_);
        sample.influences = options_.influences;
        sample.weights.assign(sample.vertex_count() * sample.influences, {});
        fit_weights(sample, execution_);
        alternate(sample, kFreeRounds, kSampleSweeps, 0.1, 0.3);
        drop_unused_bones(sample);
        if (options_.joints) {
            join_bones(sample);
            sample.moves_joints = true;
            alternate(sample, kJointRounds, kSampleSweeps, 0.4, 0.2);
        }
        static_cast<Bones&>(skin_) = std::move(sample);
        skin_.moves_joints = options_.joints;
        skin_.weights.assign(skin_.vertex_count() * skin_.influences, {});
        fit_weights(skin_, execution_);
        alternate(skin_, kWholeRounds, kSweeps, 0.6, 0.4);
    }

    /// About the fewest bones that reach the error, which falls about as their number grows.
    void search() {
        Index bones = options_.count, failed = 0, enough = kMostBones + 1;
        part_ = 0.5;  // one search may be enough
        Bones best;
        for (int run = 0; run < kMostSearches; ++run) {
            find(bones);
            done_ += std::exchange(part_, part_ / 2.0);
            const Eigen::MatrixXf far = distances(skin_, execution_);
            const double error = clip_.size * std::sqrt(far.squaredNorm() / static_cast<double>(far.size()));
            const bool is_reached = error <= options_.error;
            if (is_reached || enough > kMostBones) best = skin_;
            (is_reached ? enough : failed) = bones;
            const bool is_close = is_reached && error >= kCloseEnough * options_.error;
            if (is_close || failed + 1 >= enough || skin_.bone_count() < bones) break;
            const double wanted = bones * error / (kAimedAt * options_.error);
            bones = static_cast<Index>(std::clamp(std::round(wanted), failed + 1.0, enough - 1.0));
        }
        static_cast<Bones&>(skin_) = std::move(best);
    }

    void take_armature() {
        const Armature& armature = options_.armature;
        const auto bones = static_cast<Index>(armature.parents.size());
        require_count("armature's heads", armature.heads.rows(), "position", bones, "bones by its parents");
        require_count("armature's tails", armature.tails.rows(), "position", bones, "bones by its parents");
        require_finite(armature.heads, "armature's heads");
        require_finite(armature.tails, "armature's tails");
        const Positions heads = placed(armature.heads), tails = placed(armature.tails);
        for (Index j = 0; j < bones; ++j) {
            if (armature.parents[j] < -1 || armature.parents[j] >= j)
                throw InvalidInput(message("armature's parents[", j, "] is ", armature.parents[j],
                                           "; give a bone before it, or -1 for a root"));
            skin_.joints.push_back({armature.parents[j], heads.row(j)});
        }
        skin_.motion = Eigen::MatrixXd::Zero(skin_.frames.rows(), 4 * bones);
        skin_.weights.assign(skin_.vertex_count() * skin_.influences, {});
        if (!armature.transforms.empty()) {
            take_motion();
            return alternate(skin_, kGivenRounds, kSweeps, 0.0, 1.0);
        }
        Positions ends(2 * bones, 3);
        ends << heads, tails;
        Triangles lines(bones, 3);
        for (Index j = 0; j < bones; ++j)
            lines.row(j) << j, bones + j, bones + j;
        const std::vector<Index> one_part(2 * bones, 0);
        const TriangleTree tree(ends, lines, one_part, execution_);
        for (Index v = 0; v < skin_.vertex_count(); ++v)
            skin_.weights[v * skin_.influences] = {
                tree.nearest({skin_.rest.col(v).head<3>()}, std::numeric_limits<double>::infinity()).triangle, 1.0};
        alternate(skin_, kGivenRounds, kSweeps, 0.0, 1.0);
    }

    void take_motion() {
        const auto& transforms = options_.armature.transforms;
        const Index bones = skin_.bone_count();
        require_count("armature's transforms", transforms.size(), "matrix",
                      static_cast<std::size_t>(skin_.frame_count()) * bones, "bones in all frames");
        for (Index k = 0; k < static_cast<Index>(transforms.size()); ++k) {
            const Index f = k / bones, j = k % bones;
            Eigen::Matrix<double, 3, 4> moved = transforms[k].topRows<3>();
            moved.col(3) = (moved * clip_.center.homogeneous() - clip_.centers.row(f).transpose()) / clip_.size;
            const Matrix3 turn = moved.leftCols<3>();
            if (!moved.allFinite() || !turn.isUnitary(kRigid) || turn.determinant() < 0.0 ||
                moved.cwiseAbs().maxCoeff() >= kMostGrowth)
                throw InvalidInput(message("armature's transforms[", f, ", ", j, "] is no turn and move of at most ",
                                           kMostGrowth, " sizes; give bones that do not grow"));
            skin_.motion.block<3, 4>(3 * f, 4 * j) = moved;
        }
    }

    BoneFit result() const {
        const Index bones = skin_.bone_count();
        BoneFit fit{{}, options_.armature, distances(skin_, execution_) * static_cast<float>(clip_.size)};
        fit.weights.setZero(skin_.vertex_count(), bones);
        for (std::size_t k = 0; k < skin_.weights.size(); ++k)
            if (const auto& [bone, weight] = skin_.weights[k]; weight > 0.0)
                fit.weights(k / skin_.influences, bone) = weight;
        if (!fit.armature.transforms.empty()) return fit;
        for (Index k = 0; k < skin_.frame_count() * bones; ++k) {
            Transform transform = Transform::Identity();
            transform.topRows<3>() = skin_.motion.block<3, 4>(3 * (k / bones), 4 * (k % bones));
            transform.topRightCorner<3, 1>() = clip_.size * transform.topRightCorner<3, 1>() +
                                               clip_.centers.row(k / bones).transpose() -
                                               transform.topLeftCorner<3, 3>() * clip_.center;
            fit.armature.transforms.push_back(transform);
        }
        if (fit.armature.parents.empty()) draw_bones(fit.armature);
        return fit;
    }

    /// Tails are where children begin, else beyond the middle of what a bone carries.
    void draw_bones(Armature& armature) const {
        const Eigen::MatrixXd sums = shares(skin_);
        const double diagonal = bounding_box_diagonal(*clip_.rest) / clip_.size;
        armature.heads = armature.tails = Positions::Zero(skin_.bone_count(), 3);
        std::vector<double> children(skin_.bone_count(), 0.0);
        for (Index j = skin_.bone_count() - 1; j >= 0; --j) {
            const auto& [parent, head] = skin_.joints[j];
            armature.parents.insert(armature.parents.begin(), parent);
            const Eigen::Vector4d sum = sums.block<4, 1>(4 * j, 4 * j + 3);
            Vector3 along = 2.0 * (sum.head<3>() / std::max(sum(3), kRounding) - head);
            if (children[j] > 0.0) along = armature.tails.row(j).transpose() / children[j] - head;
            if (along.norm() < kCoincident) along = kCoincident * Vector3::UnitZ();
            along *= std::clamp(along.norm(), kShortest * diagonal, kLongest * diagonal) / along.norm();
            armature.heads.row(j) = clip_.size * head + clip_.center;
            armature.tails.row(j) = clip_.size * (head + along) + clip_.center;
            if (parent < 0) continue;
            armature.tails.row(parent) += head.transpose();
            ++children[parent];
        }
    }

    const BoneClip& clip_;
    const BoneOptions& options_;
    Execution& execution_;
    double done_ = 0.0, part_ = 1.0;  // of the work: before the search that is on, and of that
    Skin skin_;
};

}  // namespace

BoneClip::BoneClip(SharedPositions given, Index frame_count, Triangles given_faces)
    : rest(std::move(given)), faces(std::move(given_faces)) {
    require_finite(*rest, "rest");
    require_moderate_extent(*rest);
    require_triangles(static_cast<Index>(rest->rows()), faces);
    if (bounding_box_diagonal(*rest) == 0.0) throw InvalidInput("rest has its vertices in one place; give a mesh");
    if (frame_count < 1) throw InvalidInput("frames are none; give one or more");
    center = mean_row(*rest);
    size = std::sqrt((rest->rowwise() - center.transpose()).rowwise().squaredNorm().mean());
    centers.setZero(frame_count, 3);
    frames.setZero(3 * frame_count, rest->rows());
}

void BoneClip::set_frame(Index frame, const PositionsView& positions) {
    const std::string name = message("frames[", frame, "]");
    require_count(name.c_str(), positions.rows(), "position", rest->rows(), "vertices of rest");
    require_finite(positions, name.c_str());
    centers.row(frame) = mean_row(positions);
    frames.middleRows<3>(3 * frame) = ((positions.rowwise() - centers.row(frame)) / size).transpose().cast<float>();
    if (!(frames.middleRows<3>(3 * frame).cwiseAbs().maxCoeff() < kMostGrowth))
        throw InvalidInput(message(name, " is over ", kMostGrowth, " times as large as rest; give both in one unit"));
}

BoneFit fit_bones(const BoneClip& clip, const BoneOptions& options, Execution& execution) {
    if (options.count < 1 || options.count > kMostBones)
        throw InvalidInput(message("count is ", options.count, "; give 1 to ", kMostBones, " bones"));
    if (options.influences < 1 || options.influences > kMostInfluences)
        throw InvalidInput(message("influences is ", options.influences, "; give 1 to ", kMostInfluences));
    if (!(options.error >= 0.0)) throw InvalidInput(message("error is ", options.error, "; give a distance"));
    pin_eigen_cache_sizes();
    execution.begin_stage("bones");
    return BoneFitting(clip, options, execution).fit();
}

}  // namespace meanvalue
