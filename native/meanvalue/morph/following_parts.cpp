#include "meanvalue/morph/following_parts.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/mesh/components.h"

namespace meanvalue {
namespace {

// Parts that are smaller than this share of the largest one may follow, of their size in all shapes.
constexpr double kSmall = 0.5;
// A part follows where being carried from shape to shape misses it by no more than this share of how far it goes.
constexpr double kMisses = 0.5;

struct Box {
    Eigen::RowVector3d low;
    Eigen::RowVector3d high;
};

/// Of each part, the product of its sizes in all shapes.
std::vector<double> sizes_of(const std::vector<Positions>& shapes, const Components& components,
                             const Execution& execution) {
    std::vector<double> sizes(components.parts.size(), 1.0);
    for (const Positions& shape : shapes) {
        std::vector<Box> boxes(components.parts.size());
        std::vector<char> is_begun(components.parts.size(), 0);
        for (std::size_t v = 0; v < components.part_of.size(); ++v) {
            execution.check_every(v);
            const Index part = components.part_of[v];
            const auto place = shape.row(static_cast<Index>(v));
            if (!is_begun[part]) boxes[part] = {place, place};
            is_begun[part] = 1;
            boxes[part].low = boxes[part].low.cwiseMin(place);
            boxes[part].high = boxes[part].high.cwiseMax(place);
        }
        double largest = 0.0;
        for (const Box& box : boxes)
            largest = std::max(largest, (box.high - box.low).norm());
        for (std::size_t part = 0; part < sizes.size(); ++part)
            sizes[part] *= largest > 0.0 ? (boxes[part].high - boxes[part].low).norm() / largest : 1.0;
    }
    return sizes;
}

}  // namespace

FollowingParts::FollowingParts(const std::vector<Positions>& shapes, const TrianglesView& faces,
                               const std::vector<char>& is_anchored, int threads, const Execution& execution) {
    Components components = find_components(shapes[0], faces, is_anchored, execution);
    const std::vector<double> sizes = sizes_of(shapes, components, execution);
    const double largest = *std::max_element(sizes.begin(), sizes.end());
    const double small = largest * std::pow(kSmall, static_cast<double>(shapes.size()));
    std::vector<char> may_follow(components.parts.size(), 0);
    for (std::size_t part = 0; part < components.parts.size(); ++part) {
        may_follow[part] = components.fixed[part].empty() && sizes[part] < small ? 1 : 0;
        if (!may_follow[part] && components.fixed[part].empty())
            components.fixed[part].push_back(components.parts[part].first_vertex);
    }
    if (std::count(may_follow.begin(), may_follow.end(), 1) == 0) return;
    for (const Positions& shape : shapes)
        carried_by_.emplace_back(shape, faces, components, execution);

    // Squared distances over all pairs of shapes: of where a part is from where it is carried, and from where it was.
    std::vector<double> missed(components.parts.size(), 0.0);
    std::vector<double> gone(components.parts.size(), 0.0);
    for (std::size_t to = 0; to < shapes.size(); ++to) {
        Positions positions = shapes[to];
        for (std::size_t from = 0; from < shapes.size(); ++from) {
            if (from == to) continue;
            carried_by_[from].carry(shapes[from], positions.data(), threads, execution);
            const Eigen::RowVector3d shift = shapes[to].colwise().mean() - shapes[from].colwise().mean();
            for (std::size_t v = 0; v < components.part_of.size(); ++v) {
                const Index part = components.part_of[v];
                if (!may_follow[part]) continue;
                const auto row = static_cast<Index>(v);
                missed[part] += (positions.row(row) - shapes[to].row(row)).squaredNorm();
                gone[part] += (shapes[from].row(row) + shift - shapes[to].row(row)).squaredNorm();
            }
        }
    }
    follows_.assign(components.part_of.size(), 0);
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        execution.check_every(v);
        const Index part = components.part_of[v];
        if (!may_follow[part] || missed[part] > kMisses * kMisses * gone[part]) continue;
        follows_[v] = 1;
        vertices_.push_back(static_cast<Index>(v));
    }
    if (vertices_.empty()) *this = FollowingParts();
}

Positions FollowingParts::carried(const std::vector<Positions>& shapes, const ShapeWeights& weights,
                                  const Positions& positions, int threads, const Execution& execution) const {
    Positions result = positions;
    if (empty()) return result;
    Positions moved = positions;
    for (const Index v : vertices_)
        result.row(v).setZero();
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (weights.is_uniform() && weights.mean()[k] == 0.0) continue;
        carried_by_[k].carry(shapes[k], moved.data(), threads, execution);
        for (const Index v : vertices_)
            result.row(v) += weights.of(v)[k] * moved.row(v);
    }
    return result;
}

std::size_t FollowingParts::bytes() const {
    std::size_t total = follows_.capacity() + vertices_.capacity() * sizeof(Index);
    for (const LooseParts& parts : carried_by_)
        total += parts.bytes();
    return total;
}

}  // namespace meanvalue
