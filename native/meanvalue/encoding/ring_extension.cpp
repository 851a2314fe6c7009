#include "meanvalue/encoding/ring_extension.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <unordered_set>
#include <utility>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

constexpr int kWidestExtension = 3;
// Of a neighbor with more neighbors than this, so many are taken, spread over its ring: where many vertices share one
// in a collapsed place, each would have a ring of them all.
constexpr std::ptrdiff_t kMostOfNeighbour = 32;

/// The direction in which the points vary least. Its sign is arbitrary: reversing it reverses the ring, its
/// normal and the heights alike, and the predictor stays the same.
Vector3 plane_normal(const PositionsView& positions, const std::vector<Index>& points, const Vector3& centroid) {
    Matrix3 covariance = Matrix3::Zero();
    for (const Index v : points) {
        const Vector3 offset = Vector3(positions.row(v)) - centroid;
        covariance += offset * offset.transpose();
    }
    return Eigen::SelfAdjointEigenSolver<Matrix3>(covariance).eigenvectors().col(0);
}

std::vector<Index> sorted_by_angle(const PositionsView& positions, const std::vector<Index>& points) {
    const Vector3 centroid = mean_row(positions(points, Eigen::all));
    const Vector3 normal = plane_normal(positions, points, centroid);
    const Vector3 axis_u = normal.unitOrthogonal();
    const Vector3 axis_v = normal.cross(axis_u);
    std::vector<std::pair<double, std::size_t>> angles;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vector3 offset = Vector3(positions.row(points[k])) - centroid;
        angles.emplace_back(arc_tangent(axis_v.dot(offset), axis_u.dot(offset)), k);
    }
    std::sort(angles.begin(), angles.end());
    std::vector<Index> sorted;
    sorted.reserve(angles.size());
    for (const auto& [angle, k] : angles)
        sorted.push_back(points[k]);
    return sorted;
}

}  // namespace

bool spans_a_plane(const PositionsView& positions, const Index* ring, Index valence) {
    if (valence < 3) return false;
    double perimeter = 0.0;
    for (Index k = 0; k < valence; ++k) {
        perimeter += (positions.row(ring[k + 1 < valence ? k + 1 : 0]) - positions.row(ring[k])).norm();
    }
    const RingArea polygon = ring_area(positions, ring, valence);
    return polygon.area.norm() > kCoincident * perimeter * perimeter;
}

std::vector<Index> extended_ring(const PositionsView& positions, const OneRings& rings, Index vertex) {
    std::vector<Index> reached(rings.begin(vertex), rings.end(vertex));
    std::unordered_set<Index> known(reached.begin(), reached.end());
    known.insert(vertex);
    std::size_t border = 0;
    for (int width = 2; width <= kWidestExtension; ++width) {
        const std::size_t border_end = reached.size();
        for (; border < border_end; ++border) {
            const Index neighbour = reached[border];
            const std::ptrdiff_t count = rings.end(neighbour) - rings.begin(neighbour);
            const std::ptrdiff_t taken = std::min(count, kMostOfNeighbour);
            for (std::ptrdiff_t k = 0; k < taken; ++k) {
                const Index other = rings.begin(neighbour)[k * count / taken];
                if (known.insert(other).second) reached.push_back(other);
            }
        }
        if (reached.size() < 3) continue;
        std::vector<Index> ring = sorted_by_angle(positions, reached);
        if (spans_a_plane(positions, ring.data(), static_cast<Index>(ring.size()))) return ring;
    }
    return {};
}

}  // namespace meanvalue
