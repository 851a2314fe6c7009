#include "meanvalue/morph/following_parts.h"

#include <algorithm>

#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// Parts that are smaller than this share of the largest one may follow. At 1 rounding decides between equal parts.
constexpr double kSmall = 0.5;
// A part follows where being carried from shape to shape misses it by no more than this share of how far it goes.
constexpr double kMisses = 0.5;

/// Parts that are small in every shape.
std::vector<char> small_parts(const std::vector<PositionsView>& shapes, const Components& components,
                              const Execution& execution) {
    std::vector<char> is_small(components.parts.size(), 1);
    for (const PositionsView& shape : shapes) {
        execution.check();
        std::vector<Eigen::AlignedBox3d> boxes(is_small.size());
        for (Index v = 0; v < shape.rows(); ++v)
            boxes[components.part_of[v]].extend(shape.row(v).transpose());
        double largest = 0.0;
        for (const Eigen::AlignedBox3d& box : boxes)
            largest = std::max(largest, box.diagonal().norm());
        for (std::size_t part = 0; part < boxes.size(); ++part)
            is_small[part] &= boxes[part].diagonal().norm() < kSmall * largest ? 1 : 0;
    }
    return is_small;
}

}  // namespace

FollowingParts::FollowingParts(const std::vector<PositionsView>& shapes, const TrianglesView& faces,
                               Components components, int threads, const Execution& execution) {
    std::vector<char> may_follow = small_parts(shapes, components, execution);
    for (std::size_t part = 0; part < components.parts.size(); ++part) {
        may_follow[part] &= components.is_loose(part) ? 1 : 0;
        if (!may_follow[part] && components.is_loose(part))
            components.fixed[part].push_back(components.parts[part].first_vertex);
    }
    if (std::count(may_follow.begin(), may_follow.end(), 1) == 0) return;
    carried_by_.resize(shapes.size());
    parallel_items(shapes.size(), threads, execution, [&](int, std::size_t k) {
        carried_by_[k] =
            LooseParts(shapes[k], faces, components, FollowKind::kRigid, InstructionSet::kPortable, 1, execution);
    });
    const std::vector<char> is_carried = parts_carried_along(shapes, components, may_follow, threads, execution);
    follows_.assign(components.part_of.size(), 0);
    for (std::size_t v = 0; v < follows_.size(); ++v) {
        if (!is_carried[components.part_of[v]]) continue;
        follows_[v] = 1;
        vertices_.push_back(static_cast<Index>(v));
    }
    if (vertices_.empty()) *this = FollowingParts();
}

std::vector<char> FollowingParts::parts_carried_along(const std::vector<PositionsView>& shapes,
                                                      const Components& components,
                                                      const std::vector<char>& may_follow, int threads,
                                                      const Execution& execution) const {
    std::vector<double> missed(components.parts.size(), 0.0);  // squared distances from where a part is carried
    std::vector<double> gone(components.parts.size(), 0.0);    // and from where it was
    for (std::size_t from = 0; from < shapes.size(); ++from) {
        const PositionsView& to = shapes[(from + 1) % shapes.size()];
        Positions positions = to;
        carried_by_[from].carry(shapes[from], positions.data(), threads, execution);
        const Eigen::RowVector3d shift = (mean_row(to) - mean_row(shapes[from])).transpose();
        for (Index v = 0; v < to.rows(); ++v) {
            const Index part = components.part_of[v];
            if (!may_follow[part]) continue;
            missed[part] += (positions.row(v) - to.row(v)).squaredNorm();
            gone[part] += (shapes[from].row(v) + shift - to.row(v)).squaredNorm();
        }
    }
    std::vector<char> is_carried(components.parts.size(), 0);
    for (std::size_t part = 0; part < is_carried.size(); ++part)
        is_carried[part] = may_follow[part] && missed[part] <= kMisses * kMisses * gone[part] ? 1 : 0;
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

}  // namespace meanvalue
