#include "meanvalue/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

constexpr Index kLeaf = 8;  // triangles

/// The weight of b of the place on the segment from a to b.
double share_along(const Vector3& a, const Vector3& b, const Vector3& point) {
    const Vector3 along = b - a;
    const double square = along.squaredNorm();
    return square > 0.0 ? std::clamp((point - a).dot(along) / square, 0.0, 1.0) : 0.0;
}

/// Weights of the corners a, b and c of a triangle, which may be a line or a point: inside where the point is above
/// it, else on the nearest of its sides.
Vector3 nearest_on(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& point) {
    const Vector3 normal = (b - a).cross(c - a);
    const auto area = [&](const Vector3& from, const Vector3& to) {
        return normal.dot((to - from).cross(point - from));
    };
    const Vector3 areas(area(b, c), area(c, a), area(a, b));
    if (areas.minCoeff() >= 0.0 && areas.sum() > 0.0 && std::isfinite(areas.sum())) return areas / areas.sum();
    Vector3 best(1.0, 0.0, 0.0);
    double least = std::numeric_limits<double>::infinity();
    const std::array<const Vector3*, 3> corners = {&a, &b, &c};
    for (int side = 0; side < 3; ++side) {
        const int next = (side + 1) % 3;
        const double share = share_along(*corners[side], *corners[next], point);
        Vector3 weights = Vector3::Zero();
        weights[side] = 1.0 - share;
        weights[next] = share;
        const double square = (a * weights[0] + b * weights[1] + c * weights[2] - point).squaredNorm();
        if (square < least) {
            least = square;
            best = weights;
        }
    }
    return best;
}

}  // namespace

TriangleTree::TriangleTree(const PositionsView& positions, Triangles triangles, const std::vector<Index>& part_of,
                           const Execution& execution)
    : positions_(positions), triangles_(std::move(triangles)), part_of_(part_of) {
    if (triangles_.size() > 0 && (triangles_.minCoeff() < 0 || triangles_.maxCoeff() >= positions.rows())) {
        throw InvalidInput(message("a triangle has a corner that is none of the ", positions.rows(), " vertices"));
    }
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

TriangleTree::Place TriangleTree::nearest(const Query& query, double reach) const {
    Place found;
    double least = std::min(reach * reach, std::numeric_limits<double>::max());
    if (!boxes_.empty()) search(0, query, least, found);
    return found;
}

void TriangleTree::search(Index number, const Query& query, double& least, Place& found) const {
    const Box& box = boxes_[number];
    const auto apart = [&](const Box& other) {
        return (query.point - query.point.cwiseMax(other.low).cwiseMin(other.high)).squaredNorm();
    };
    if (box.part == query.part || !(apart(box) <= least)) return;
    if (box.second >= 0) {
        const bool is_first = apart(boxes_[number + 1]) <= apart(boxes_[box.second]);
        search(is_first ? number + 1 : box.second, query, least, found);
        search(is_first ? box.second : number + 1, query, least, found);
        return;
    }
    for (Index k = box.begin; k < box.end; ++k) {
        const auto corner = triangles_.row(order_[k]);
        if (part_of_[corner[0]] == query.part) continue;
        const Vector3 a = positions_.row(corner[0]);
        const Vector3 b = positions_.row(corner[1]);
        const Vector3 c = positions_.row(corner[2]);
        if (query.normal) {
            const Vector3 normal = (b - a).cross(c - a);
            if (!(normal.dot(*query.normal) > query.least_cosine * normal.norm())) continue;
        }
        const Vector3 weights = nearest_on(a, b, c, query.point);
        const Vector3 place = a * weights[0] + b * weights[1] + c * weights[2];
        const double square = (place - query.point).squaredNorm();
        if (!(square <= least) || (square == least && found.triangle >= 0 && order_[k] > found.triangle)) continue;
        least = square;
        found = {order_[k], weights, place};
    }
}

}  // namespace meanvalue
