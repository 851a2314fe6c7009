#include "meanvalue/examples/surface_functions.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "meanvalue/common/mean_row.h"

namespace meanvalue {
namespace {

// About one for each limb and joint of a figure. More of them follow the anchors' noise.
constexpr Index kFunctions = 12;
// How far a function reaches, over the mean distance of a vertex from the second nearest center: with a smaller one
// there are steps between functions, with a larger one they are alike.
constexpr double kReach = 1.7;
// It reaches at least this many times the largest distance of a vertex from its nearest center: each vertex has one.
constexpr double kReachOverFarthest = 1.2;

/// Distances along edges from `source` (Dijkstra 1959); in a straight line to vertices that no edges lead to.
std::vector<double> distances_from(Index source, const Encoding& layout, const PositionsView& positions,
                                   const Execution& execution) {
    constexpr double kUnreached = std::numeric_limits<double>::infinity();
    std::vector<double> distance(positions.rows(), kUnreached);
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance[source] = 0.0;
    queue.emplace(0.0, source);
    for (std::size_t step = 0; !queue.empty(); ++step) {
        execution.check_every(step);
        const auto [here, vertex] = queue.top();
        queue.pop();
        if (here > distance[vertex]) continue;
        const EncodedRing ring = layout.ring_of(vertex);
        for (Index k = 0; k < ring.valence; ++k) {
            const Index next = ring.ring[k];
            const double there = here + (positions.row(vertex) - positions.row(next)).norm();
            if (!(there < distance[next])) continue;
            distance[next] = there;
            queue.emplace(there, next);
        }
    }
    for (std::size_t v = 0; v < distance.size(); ++v) {
        if (distance[v] == kUnreached) distance[v] = (positions.row(source) - positions.row(v)).norm();
    }
    return distance;
}

}  // namespace

SurfaceFunctions::SurfaceFunctions(const Encoding& layout, const PositionsView& positions,
                                   const Execution& execution) {
    const auto vertex_count = static_cast<std::size_t>(positions.rows());
    start_.push_back(0);
    if (vertex_count == 0) return;
    const Eigen::RowVector3d centroid = mean_row(positions).transpose();
    std::vector<double> nearest(vertex_count);
    for (std::size_t v = 0; v < vertex_count; ++v)
        nearest[v] = (positions.row(v) - centroid).norm();
    std::vector<std::vector<double>> distances;  // from each center
    std::vector<double> second(vertex_count, std::numeric_limits<double>::infinity());
    while (static_cast<Index>(distances.size()) < kFunctions) {
        const auto center = std::max_element(nearest.begin(), nearest.end());
        if (!distances.empty() && !(*center > 0.0)) break;
        distances.push_back(
            distances_from(static_cast<Index>(center - nearest.begin()), layout, positions, execution));
        if (distances.size() == 1) {
            nearest = distances.back();
            continue;
        }
        for (std::size_t v = 0; v < vertex_count; ++v) {
            second[v] = std::min(second[v], std::max(nearest[v], distances.back()[v]));
            nearest[v] = std::min(nearest[v], distances.back()[v]);
        }
    }
    count_ = static_cast<Index>(distances.size());
    const double sum = std::accumulate(second.begin(), second.end(), 0.0);
    const double farthest = *std::max_element(nearest.begin(), nearest.end());
    const double mean = count_ > 1 ? sum / static_cast<double>(vertex_count) : 0.0;
    const double reach = std::max(kReach * mean, kReachOverFarthest * farthest);
    for (std::size_t v = 0; v < vertex_count; ++v) {
        execution.check_every(v);
        double total = 0.0;
        for (Index c = 0; c < count_; ++c) {
            const double share = reach > 0.0 ? distances[c][v] / reach : 0.0;
            if (!(share < 1.0)) continue;
            const double root = (1.0 - share * share) * (1.0 - share * share);
            values_.push_back({c, root * root});
            total += root * root;
        }
        for (std::size_t k = start_.back(); k < values_.size(); ++k)
            values_[k].value /= total;
        start_.push_back(values_.size());
    }
}

}  // namespace meanvalue
