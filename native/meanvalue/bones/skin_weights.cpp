#include <algorithm>
#include <numeric>

#include "meanvalue/bones/skin.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

constexpr std::size_t kMostCandidates = 16;
constexpr Index kNearest = 10;
constexpr double kSmoothness = 1e-4;

using Numbers = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostCandidates, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostCandidates, kMostCandidates>;

/// The weights of one vertex after another, for the motion as it is.
class VertexWeights {
  public:
    VertexWeights(const Skin& skin, const Eigen::MatrixXd& products)
        : skin_(skin), products_(products), mean_(skin.bone_count()) {}

    /// @param aims 4b: M^T v. @param[out] result as many as the skin has influences.
    void find(Index vertex, const Eigen::Ref<const Eigen::VectorXd>& aims, Weighted* result) {
        place_ = skin_.rest.col(vertex);
        find_nearest(aims);
        if (skin_.influences == 1) {
            *result = {candidates_.front(), 1.0};
            return;
        }
        look_around(vertex);
        const auto count = static_cast<Index>(candidates_.size());
        Square squares(count, count);  // what is lessened is w^T squares w - 2 wanted^T w
        Numbers wanted(count);
        for (Index k = 0; k < count; ++k) {
            const Index j = candidates_[k];
            wanted(k) = place_.dot(aims.segment<4>(4 * j)) + kSmoothness * mean_(j);
            for (Index l = 0; l <= k; ++l)
                squares(k, l) = squares(l, k) = place_.dot(products_.block<4, 4>(4 * j, 4 * candidates_[l]) * place_);
            squares(k, k) += kSmoothness;
        }
        // Bones are taken away one by one until no weight is negative and no more are left than may be.
        std::vector<Index> left(count);
        std::iota(left.begin(), left.end(), 0);
        for (;;) {
            const Eigen::LLT<Square> factor(Square(squares(left, left)));
            const Numbers ones = factor.solve(Numbers::Ones(left.size()));
            Numbers weights = factor.solve(wanted(left));
            weights -= (weights.sum() - 1.0) / ones.sum() * ones;
            weights /= weights.sum();
            Index least = 0;
            const double smallest = weights.minCoeff(&least);
            if (left.size() == 1 || (smallest > 0.0 && static_cast<Index>(left.size()) <= skin_.influences)) {
                for (std::size_t k = 0; k < left.size(); ++k)
                    result[k] = {candidates_[left[k]], weights(k)};
                return;
            }
            left.erase(left.begin() + least);
        }
    }

  private:
    void find_nearest(const Eigen::Ref<const Eigen::VectorXd>& aims) {
        std::vector<std::pair<double, Index>> far;
        far.reserve(skin_.bone_count());
        for (Index j = 0; j < skin_.bone_count(); ++j)
            far.emplace_back(place_.dot(products_.block<4, 4>(4 * j, 4 * j) * place_ - 2.0 * aims.segment<4>(4 * j)),
                             j);
        const auto end = far.begin() + std::min<std::ptrdiff_t>(kNearest, far.size());
        std::partial_sort(far.begin(), end, far.end());
        candidates_.clear();
        std::for_each(far.begin(), end, [&](const auto& each) { candidates_.push_back(each.second); });
    }

    /// Adds the bones that the vertex has and those of its neighbors.
    void look_around(Index vertex) {
        mean_.setZero();
        const auto around = skin_.around.of(vertex);
        const double share = 1.0 / std::max<Index>(1, around.size());
        const auto look = [&](Index other) {
            for (Index k = other * skin_.influences; k < (other + 1) * skin_.influences; ++k) {
                const auto& [bone, weight] = skin_.weights[k];
                if (weight <= 0.0) continue;
                mean_(bone) += share * weight;
                const bool is_new = std::find(candidates_.begin(), candidates_.end(), bone) == candidates_.end();
                if (is_new && candidates_.size() < kMostCandidates) candidates_.push_back(bone);
            }
        };
        look(vertex);
        if (!around.empty()) mean_.setZero();
        std::for_each(around.begin(), around.end(), look);
    }

    const Skin& skin_;
    const Eigen::MatrixXd& products_;
    Eigen::Vector4d place_;
    Eigen::VectorXd mean_;  // of the neighbors' weights
    std::vector<Index> candidates_;
};

}  // namespace

void fit_weights(Skin& skin, const Execution& execution) {
    const double frames = skin.frame_count();
    const Eigen::MatrixXd products = skin.motion.transpose() * skin.motion / frames;
    std::vector<Weighted> weights(skin.weights.size());
    parallel_pieces(skin.vertex_count(), skin.threads, execution, [&](Index, Index begin, Index end) {
        const Eigen::MatrixXd aims =
            skin.motion.transpose() * skin.frames.middleCols(begin, end - begin).cast<double>() / frames;
        VertexWeights finder(skin, products);
        for (Index v = begin; v < end; ++v)
            if (skin.first[v] == v) finder.find(v, aims.col(v - begin), &weights[v * skin.influences]);
    });
    for (Index v = 0; v < skin.vertex_count(); ++v)
        std::copy_n(&weights[skin.first[v] * skin.influences], skin.influences, &weights[v * skin.influences]);
    skin.weights.swap(weights);
}

}  // namespace meanvalue
