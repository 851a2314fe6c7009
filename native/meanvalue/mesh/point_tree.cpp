#include "meanvalue/mesh/point_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace meanvalue {
PointTree::PointTree(const PositionsView& positions, std::vector<Index> rows, const Execution& execution)
    : positions_(positions), rows_(std::move(rows)), axis_(rows_.size(), 0) {
    split({0, rows_.size()}, execution);
}

void PointTree::split(Range range, const Execution& execution) {
    if (range.second - range.first < 2) return;
    execution.check();
    Vector3 low = positions_.row(rows_[range.first]);
    Vector3 high = low;
    for (std::size_t k = range.first; k < range.second; ++k) {
        const Vector3 point = positions_.row(rows_[k]);
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = middle_of(range);
    const auto begin = rows_.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(range.first), begin + static_cast<std::ptrdiff_t>(middle),
                     begin + static_cast<std::ptrdiff_t>(range.second), [&](Index a, Index b) {
                         return std::make_tuple(positions_(a, axis), a) < std::make_tuple(positions_(b, axis), b);
                     });
    axis_[middle] = static_cast<unsigned char>(axis);
    split({range.first, middle}, execution);
    split({middle + 1, range.second}, execution);
}

PointTree::Nearest PointTree::nearest(const Vector3& point) const {
    Nearest best{rows_.front(), std::numeric_limits<double>::infinity()};
    search({0, rows_.size()}, point, best);
    return best;
}

bool PointTree::has_within(const Vector3& point, double squared_distance) const {
    Nearest best{-1, std::nextafter(squared_distance, std::numeric_limits<double>::infinity())};
    search({0, rows_.size()}, point, best);
    return best.row >= 0;
}

void PointTree::search(Range range, const Vector3& point, Nearest& best) const {
    if (range.first == range.second) return;
    const std::size_t middle = middle_of(range);
    const double distance = (Vector3(positions_.row(rows_[middle])) - point).squaredNorm();
    if (distance < best.squared_distance) best = {rows_[middle], distance};
    const int axis = axis_[middle];
    const double off = point(axis) - positions_(rows_[middle], axis);
    const Range low{range.first, middle};
    const Range high{middle + 1, range.second};
    search(off < 0.0 ? low : high, point, best);
    if (off * off < best.squared_distance) search(off < 0.0 ? high : low, point, best);
}

}  // namespace meanvalue
