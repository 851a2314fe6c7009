#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "meanvalue/bones/skin.h"

namespace meanvalue {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr Index kRounds = 20, kMostPasses = 16;
constexpr std::size_t kSeedVertices = 60;
constexpr double kMovesAlike = 1e-12;    // squared, a frame: what single precision leaves
constexpr double kDrawnToCenter = 1e-4;  // joints
constexpr double kFarFromCenter = 0.05;
constexpr double kNearMiddle = 0.25;   // squared: where roots are
constexpr double kLeastShared = 1e-6;  // of all weights: below it two bones have nothing to do with each other

/// Where two bones move apart least, and how bad a joint that is.
std::pair<double, Vector3> joint_of(const Eigen::MatrixXd& products, const Eigen::MatrixXd& shared, Index j,
                                    Index k) {
    const Eigen::Vector4d share = shared.block<4, 1>(4 * j, 4 * k + 3);
    if (share(3) <= kLeastShared) return {kNone, Vector3::Zero()};
    const Vector3 center = share.hnormalized();
    const auto product = [&](Index of, Index with) { return products.block<4, 4>(4 * of, 4 * with); };
    const Eigen::Matrix4d apart = product(j, j) - product(j, k) - product(k, j) + product(k, k);
    const Matrix3 drawn = apart.topLeftCorner<3, 3>() + kDrawnToCenter * Matrix3::Identity();
    const Vector3 place = drawn.ldlt().solve(kDrawnToCenter * center - apart.topRightCorner<3, 1>());
    const double error = std::sqrt(std::max(0.0, place.homogeneous().dot(apart * place.homogeneous())));
    return {(error + kFarFromCenter * (place - center).norm()) / share(3), place};
}

/// Renumbers bones: they are those of `kept`.
void keep_bones(Skin& skin, const std::vector<Index>& kept) {
    const Eigen::MatrixXd motion = skin.motion;
    skin.motion.resize(motion.rows(), static_cast<Index>(4 * kept.size()));
    std::vector<Index> number(skin.bone_count(), -1);
    for (Index k = 0; k < static_cast<Index>(kept.size()); ++k) {
        number[kept[k]] = k;
        skin.motion.middleCols<4>(4 * k) = motion.middleCols<4>(4 * kept[k]);
    }
    skin.joints = picked(skin.joints, kept);
    for (Weighted& influence : skin.weights)
        if (influence.weight > 0.0) influence.number = number[influence.number];
}

}  // namespace

void drop_unused_bones(Skin& skin) {
    std::set<Index> used;
    for (const Weighted& influence : skin.weights)
        if (influence.weight > 0.0) used.insert(influence.number);
    keep_bones(skin, {used.begin(), used.end()});
}

void split_bones(Skin& skin, Index count, const Execution& execution) {
    skin.weights.assign(skin.vertex_count(), {0, 1.0});
    Index next = 1;
    for (Index pass = 0; pass < kMostPasses && next > skin.bone_count(); ++pass) {
        skin.joints.resize(next);
        skin.motion = Eigen::MatrixXd::Zero(skin.frames.rows(), 4 * next);
        fit_motion(skin, 1, execution);
        for (Index round = 0; round < kRounds; ++round) {
            fit_weights(skin, execution);
            fit_motion(skin, 1, execution);
        }
        drop_unused_bones(skin);
        next = skin.bone_count();
        const Eigen::VectorXf far = distances(skin, execution).colwise().squaredNorm();
        std::vector<std::pair<double, Index>> worst(next, {0.0, -1});  // of each bone, the vertex to split it at
        for (Index v = 0; v < skin.vertex_count(); ++v) {
            const Index j = skin.weights[v].number;
            const double off = std::sqrt(far(v)) * (skin.rest.col(v).head<3>() - skin.joints[j].place).norm();
            if (far(v) > kMovesAlike * skin.frame_count()) worst[j] = std::max(worst[j], {off, v});
        }
        std::sort(worst.rbegin(), worst.rend());
        for (const auto& [off, vertex] : worst) {
            if (vertex < 0 || next == count) break;
            std::vector<std::pair<double, Index>> near;
            for (Index v = 0; v < skin.vertex_count(); ++v)
                if (skin.weights[v].number == skin.weights[vertex].number)
                    near.emplace_back((skin.rest.col(v) - skin.rest.col(vertex)).squaredNorm(), v);
            const std::size_t seed = std::min(kSeedVertices, (near.size() + 1) / 2);
            std::nth_element(near.begin(), near.begin() + (seed - 1), near.end());
            for (std::size_t k = 0; k < seed; ++k)
                skin.weights[near[k].second].number = next;
            ++next;
        }
    }
}

void join_bones(Skin& skin) {
    const Index bones = skin.bone_count();
    Eigen::MatrixXd products(4 * bones, 4 * bones);
    products.noalias() = skin.motion.transpose() * skin.motion;
    products /= skin.frame_count();
    const Eigen::MatrixXd shared = shares(skin) / skin.vertex_count();
    std::vector<std::pair<double, double>> cost;  // of joining a bone now; where none can be, off the middle
    cost.reserve(bones);
    for (Index j = 0; j < bones; ++j)
        cost.emplace_back(kNone, (kNearMiddle + skin.joints[j].place.squaredNorm()) / shared(4 * j + 3, 4 * j + 3));
    std::vector<Joint> joints(bones);
    std::vector<Index> order, left(bones);
    std::iota(left.begin(), left.end(), 0);
    while (!left.empty()) {
        const auto best =
            std::min_element(left.begin(), left.end(), [&](Index j, Index k) { return cost[j] < cost[k]; });
        const Index next = *best;
        left.erase(best);
        const auto parent = static_cast<Index>(order.size());
        order.push_back(next);
        for (const Index j : left) {
            const auto [found, place] = joint_of(products, shared, j, next);
            if (found >= cost[j].first) continue;
            cost[j].first = found;
            joints[j] = {parent, place};
        }
    }
    skin.joints.swap(joints);
    keep_bones(skin, order);
}

}  // namespace meanvalue
