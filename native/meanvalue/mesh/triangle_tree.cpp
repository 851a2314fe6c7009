#include "meanvalue/mesh/triangle_tree.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace meanvalue {
namespace {

constexpr Index kLeaf = 8;  // triangles

/// On the segment from a to b.
Vector3 nearest_on(const Vector3& a, const Vector3& b, const Vector3& point) {
    const Vector3 along = b - a;
    const double square = along.squaredNorm();
    return square > 0.0 ? Vector3(a + std::clamp((point - a).dot(along) / square, 0.0, 1.0) * along) : a;
}

/// On the triangle with the corners a, b and c, which may be a line or a point: inside where the point is above it,
/// else on the nearest of its sides.
Vector3 nearest_on(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& point) {
    const Vector3 normal = (b - a).cross(c - a);
    const auto is_inside = [&](const Vector3& from, const Vector3& to) {
        return normal.dot((to - from).cross(point - from)) >= 0.0;
    };
    if (normal.squaredNorm() > 0.0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a)) {
        return point - normal * (normal.dot(point - a) / normal.squaredNorm());
    }
    Vector3 best = nearest_on(a, b, point);
    for (const Vector3& other : {nearest_on(b, c, point), nearest_on(c, a, point)}) {
        if ((other - point).squaredNorm() < (best - point).squaredNorm()) best = other;
    }
    return best;
}

}  // namespace

TriangleTree::TriangleTree(const PositionsView& positions, Triangles triangles, const std::vector<Index>& part_of,
                           const Execution& execution)
    : positions_(positions), triangles_(std::move(triangles)), part_of_(part_of) {
    for (Index t = 0; t < triangles_.rows(); ++t) {
        const auto corner = triangles_.row(t);
        if ((positions.row(corner[0]) + positions.row(corner[1]) + positions.row(corner[2])).allFinite()) {
            order_.push_back(t);
        }
    }
    if (!order_.empty()) add_box(0, static_cast<Index>(order_.size()), execution);
}

Index TriangleTree::add_box(Index begin, Index end, const Execution& execution) {
    execution.check_every(boxes_.size());
    const auto middle_of = [&](Index t, int axis) {
        return positions_(triangles_(t, 0), axis) + positions_(triangles_(t, 1), axis) +
               positions_(triangles_(t, 2), axis);
    };
    Box box;
    box.begin = begin;
    box.end = end;
    box.low = box.high = positions_.row(triangles_(order_[begin], 0));
    box.part = part_of_[triangles_(order_[begin], 0)];
    for (Index k = begin; k < end; ++k) {
        for (const Index corner : triangles_.row(order_[k])) {
            box.low = box.low.cwiseMin(positions_.row(corner).transpose());
            box.high = box.high.cwiseMax(positions_.row(corner).transpose());
        }
        if (part_of_[triangles_(order_[k], 0)] != box.part) box.part = -1;
    }
    const auto number = static_cast<Index>(boxes_.size());
    boxes_.push_back(box);
    if (end - begin <= kLeaf) return number;
    int axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](Index a, Index b) {
        return std::make_tuple(middle_of(a, axis), a) < std::make_tuple(middle_of(b, axis), b);
    });
    add_box(begin, middle, execution);
    const Index second = add_box(middle, end, execution);
    boxes_[number].second = second;
    return number;
}

TriangleTree::Place TriangleTree::nearest_of_others(const Vector3& point, Index part, double reach) const {
    Place found;
    double least = reach * reach;
    if (!boxes_.empty()) search(0, point, part, least, found);
    return found;
}

void TriangleTree::search(Index number, const Vector3& point, Index part, double& least, Place& found) const {
    const Box& box = boxes_[number];
    const auto apart = [&](const Box& other) {
        return (point - point.cwiseMax(other.low).cwiseMin(other.high)).squaredNorm();
    };
    if (box.part == part || apart(box) > least) return;
    if (box.second >= 0) {
        const bool is_first = apart(boxes_[number + 1]) <= apart(boxes_[box.second]);
        search(is_first ? number + 1 : box.second, point, part, least, found);
        search(is_first ? box.second : number + 1, point, part, least, found);
        return;
    }
    for (Index k = box.begin; k < box.end; ++k) {
        const auto corner = triangles_.row(order_[k]);
        if (part_of_[corner[0]] == part) continue;
        const Vector3 place =
            nearest_on(positions_.row(corner[0]), positions_.row(corner[1]), positions_.row(corner[2]), point);
        const double square = (place - point).squaredNorm();
        if (square > least || (square == least && found.triangle >= 0)) continue;
        least = square;
        found = {order_[k], place};
    }
}

}  // namespace meanvalue
