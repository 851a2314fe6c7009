#include <algorithm>

#include "meanvalue/bones/skin.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

constexpr double kDrawnToCenter = 1e-3;  // joints: of hinges, turns leave their places along the axis open
constexpr double kLeastMass = 1e-4;      // of all

/// 3f x 4b: sums of w_j v p^T over vertices, v being where one is in a frame.
Eigen::MatrixXd aims_of(const Skin& skin, const Execution& execution) {
    Eigen::MatrixXd aims = Eigen::MatrixXd::Zero(skin.frames.rows(), 4 * skin.bone_count());
    const Grouped<Index> used = grouped<Index>(skin.bone_count(), [&](const auto& add) {
        for (std::size_t k = 0; k < skin.weights.size(); ++k)
            if (skin.weights[k].weight > 0.0) add(skin.weights[k].number, static_cast<Index>(k));
    });
    parallel_items(skin.bone_count(), skin.threads, execution, [&](int, std::size_t bone) {
        WorkMeter meter(execution);
        for (const Index k : used.of(bone)) {
            const Eigen::VectorXd target = skin.frames.col(k / skin.influences).cast<double>();
            for (Index axis = 0; axis < 4; ++axis)
                aims.col(4 * bone + axis) += skin.weights[k].weight * skin.rest(axis, k / skin.influences) * target;
            meter.add(target.size());
        }
    });
    return aims;
}

/// One step of each joint's place to where it lessens what is left, for the turns as they are, and near what both
/// bones carry.
void move_joints(Skin& skin, const Eigen::MatrixXd& aims, const Eigen::MatrixXd& moments) {
    const Index bones = skin.bone_count();
    const auto shifts = Eigen::seqN(3, bones, 4);
    Eigen::MatrixXd left = aims - skin.motion * moments;
    left = left(Eigen::all, shifts).eval();
    Eigen::MatrixXd masses = moments(shifts, shifts);  // of bones with all that hang on them, as `left`
    for (Index j = bones - 1; j > 0; --j)
        if (const Index parent = skin.joints[j].parent; parent >= 0) {
            left.col(parent) += left.col(j);
            masses.col(parent) += masses.col(j);
            masses.row(parent) += masses.row(j);
        }
    const double least = kLeastMass * static_cast<double>(skin.vertex_count());
    for (Index j = 0; j < bones; ++j) {
        auto& [parent, place] = skin.joints[j];
        if (parent < 0) continue;
        const Eigen::MatrixX3d apart = skin.motion.middleCols<3>(4 * parent) - skin.motion.middleCols<3>(4 * j);
        const Eigen::Vector4d share = moments.block<4, 1>(4 * j, 4 * parent + 3);
        const Vector3 center = share(3) > 0.0 ? Vector3(share.hnormalized()) : place;
        const double pull = kDrawnToCenter * skin.frame_count() * std::max(masses(j, j), least);
        const Matrix3 square = masses(j, j) * apart.transpose() * apart + pull * Matrix3::Identity();
        const Vector3 step = square.ldlt().solve(apart.transpose() * left.col(j) + pull * (center - place));
        place += step;
        left -= apart * step * masses.row(j);
    }
}

}  // namespace

Eigen::MatrixXf distances(const Skin& skin, const Execution& execution) {
    Eigen::MatrixXf found(skin.frame_count(), skin.vertex_count());
    parallel_for(skin.vertex_count(), skin.threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            Eigen::VectorXd off = -skin.frames.col(v).cast<double>();
            for (Index k = v * skin.influences; k < (v + 1) * skin.influences; ++k)
                if (const auto& [bone, weight] = skin.weights[k]; weight > 0.0)
                    off += skin.motion.middleCols<4>(4 * bone) * (weight * skin.rest.col(v));
            found.col(v) = off.reshaped(3, found.rows()).colwise().norm().cast<float>();
        }
    });
    return found;
}

Eigen::MatrixXd shares(const Skin& skin) {
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(4 * skin.bone_count(), 4 * skin.bone_count());
    for (Index v = 0; v < skin.vertex_count(); ++v) {
        const Eigen::Matrix4d square = skin.rest.col(v) * skin.rest.col(v).transpose();
        for (Index k = v * skin.influences; k < (v + 1) * skin.influences; ++k)
            for (Index l = v * skin.influences; l < (v + 1) * skin.influences; ++l)
                if (const double both = skin.weights[k].weight * skin.weights[l].weight; both > 0.0)
                    sums.block<4, 4>(4 * skin.weights[k].number, 4 * skin.weights[l].number) += both * square;
    }
    return sums;
}

void fit_motion(Skin& skin, Index sweeps, const Execution& execution) {
    const Index bones = skin.bone_count();
    Eigen::MatrixXd moments = shares(skin), aims = aims_of(skin, execution);
    if (skin.moves_joints) move_joints(skin, aims, moments);
    // Turns of all bones, and where the places of roots are, make the motion: motion = state * chain.
    Eigen::MatrixXd chain = Eigen::MatrixXd::Identity(4 * bones, 4 * bones);
    for (Index j = 0; j < bones; ++j) {
        auto& [parent, place] = skin.joints[j];
        auto shift = chain.col(4 * j + 3);
        if (parent >= 0) {
            shift = chain.col(4 * parent + 3);
            shift.segment<3>(4 * parent) += place;
        } else if (moments(4 * j + 3, 4 * j + 3) > 0.0) {
            place = moments.block<4, 1>(4 * j, 4 * j + 3).hnormalized();
        }
        shift.segment<3>(4 * j) -= place;
    }
    aims *= chain.transpose();
    moments = chain * moments * chain.transpose();
    parallel_items(skin.frame_count(), skin.threads, execution, [&](int, std::size_t frame) {
        const auto aim = aims.middleRows<3>(3 * frame);
        Eigen::Matrix3Xd state = skin.motion.middleRows<3>(3 * frame);
        for (Index j = 0; j < bones; ++j)
            state.col(4 * j + 3) += state.middleCols<3>(4 * j) * skin.joints[j].place;
        for (Index sweep = 0; sweep < sweeps; ++sweep)
            for (Index j = 0; j < bones; ++j) {
                const Eigen::Matrix<double, 3, 4> left =
                    aim.middleCols<4>(4 * j) - state * moments.middleCols<4>(4 * j);
                const double mass = moments(4 * j + 3, 4 * j + 3);
                const auto own = moments.block<3, 3>(4 * j, 4 * j);
                auto turn = state.middleCols<3>(4 * j);
                if (mass > 0.0) state.col(4 * j + 3) += left.col(3) / mass;
                if (own.trace() > 0.0)
                    turn = closest_rotation(left.leftCols<3>() + turn * own);
                else if (skin.joints[j].parent >= 0)
                    turn = state.middleCols<3>(4 * skin.joints[j].parent).eval();
                else
                    turn.setIdentity();
            }
        skin.motion.middleRows<3>(3 * frame) = state * chain;
    });
}

}  // namespace meanvalue
