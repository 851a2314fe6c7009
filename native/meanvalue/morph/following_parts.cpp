#include "meanvalue/morph/following_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/parallel.h"

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
std::vector<double> sizes_of(const std::vector<PositionsView>& shapes, const Components& components,
                             const Execution& execution) {
    std::vector<double> sizes(components.parts.size(), 1.0);
    for (const PositionsView& shape : shapes) {
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

FollowingParts::FollowingParts(const std::vector<PositionsView>& shapes, const TrianglesView& faces,
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
    carried_by_.resize(shapes.size());
    parallel_items(shapes.size(), threads, execution,
                   [&](int, std::size_t k) { carried_by_[k] = LooseParts(shapes[k], faces, components, execution); });
    const std::vector<char> is_carried = parts_carried_along(shapes, components, may_follow, threads, execution);
    follows_.assign(components.part_of.size(), 0);
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        execution.check_every(v);
        const Index part = components.part_of[v];
        if (is_carried[part] == 0) continue;
        follows_[v] = 1;
        vertices_.push_back(static_cast<Index>(v));
    }
    if (vertices_.empty()) *this = FollowingParts();
}

std::vector<char> FollowingParts::parts_carried_along(const std::vector<PositionsView>& shapes,
                                                      const Components& components,
                                                      const std::vector<char>& may_follow, int threads,
                                                      const Execution& execution) const {
    struct Distances {
        double missed = 0.0;
        double gone = 0.0;
    };
    std::vector<Index> small;
    for (std::size_t v = 0; v < components.part_of.size(); ++v) {
        if (may_follow[components.part_of[v]]) small.push_back(static_cast<Index>(v));
    }
    std::vector<Eigen::RowVector3d> middles;
    middles.reserve(shapes.size());
    for (const PositionsView& shape : shapes)
        middles.emplace_back(shape.colwise().mean());
    // Of each shape from all others, so that the order of the sums is no matter of threads.
    std::vector<std::vector<Distances>> to_shapes(shapes.size());
    parallel_items(shapes.size(), threads, execution, [&](int, std::size_t to) {
        std::vector<Distances> sums(components.parts.size());
        Positions positions = shapes[to];
        LooseParts::StarLengths lengths(components.part_of.size(), -1.0);
        for (std::size_t from = 0; from < shapes.size(); ++from) {
            if (from == to) continue;
            carried_by_[from].carry(shapes[from], positions.data(), lengths, execution);
            const Eigen::RowVector3d shift = middles[to] - middles[from];
            for (const Index v : small) {
                Distances& sum = sums[components.part_of[v]];
                sum.missed += (positions.row(v) - shapes[to].row(v)).squaredNorm();
                sum.gone += (shapes[from].row(v) + shift - shapes[to].row(v)).squaredNorm();
            }
        }
        to_shapes[to] = std::move(sums);
    });
    std::vector<char> is_carried(components.parts.size(), 0);
    for (std::size_t part = 0; part < is_carried.size(); ++part) {
        Distances total;
        for (const std::vector<Distances>& sums : to_shapes) {
            total.missed += sums[part].missed;
            total.gone += sums[part].gone;
        }
        is_carried[part] = may_follow[part] && total.missed <= kMisses * kMisses * total.gone ? 1 : 0;
    }
    return is_carried;
}

Positions FollowingParts::carried(const std::vector<PositionsView>& shapes, const ShapeWeights& weights,
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
