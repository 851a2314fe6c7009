#include "meanvalue/follow/carrier_surface.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

constexpr double kUnreached = std::numeric_limits<double>::infinity();
// Of what is dropped from a patch: not all of it, or patches of equal weights would have none.
constexpr double kDropped = 0.999;
// Beside edges that are far longer than others a patch would go on through all of the mesh.
constexpr std::ptrdiff_t kMostWalked = 512;

Vector3 unit_or_zero(const Vector3& direction) {
    const double length = direction.norm();
    return length > 0.0 ? Vector3(direction / length) : Vector3(Vector3::Zero());
}

}  // namespace

Vector3 SurfacePlace::normal(const std::vector<Vector3>& normals) const {
    return unit_or_zero(weights[0] * normals[corners[0]] + weights[1] * normals[corners[1]] +
                        weights[2] * normals[corners[2]]);
}

Matrix3 SurfacePatch::covariance(const double* positions, const std::vector<Vector3>& normals) const {
    const Vector3 first = point_at(positions, points[0]);
    Vector3 offset = Vector3::Zero();
    Vector3 posed_normal = weights[0] * normals[points[0]];
    for (int k = 1; k < count; ++k) {
        offset += weights[k] * (point_at(positions, points[k]) - first);
        posed_normal += weights[k] * normals[points[k]];
    }
    Matrix3 result = unit_or_zero(posed_normal) * normal.transpose();
    for (int k = 0; k < count; ++k)
        result += (point_at(positions, points[k]) - first - offset) * arms[k].transpose();
    return result;
}

CarrierSurface::CarrierSurface(const PositionsView& rest, Triangles faces, double size, int threads,
                               const Execution& execution)
    : faces_(std::move(faces)),
      mean_edges_(rest.rows(), 0.0),
      areas_(rest.rows(), 0.0),
      rest_normals_(rest.rows(), Vector3::Zero()),
      size_(size) {
    faces_at_ = grouped<Index>(rest.rows(), [&](const auto& visit) {
        execution.check();
        for (Index f = 0; f < faces_.rows(); ++f) {
            for (int c = 0; c < 3; ++c)
                visit(faces_(f, c), f);
        }
    });
    neighbours_ = grouped<Index>(rest.rows(), [&](const auto& visit) {
        execution.check();
        for (Index f = 0; f < faces_.rows(); ++f) {
            for (int c = 0; c < 3; ++c) {
                visit(faces_(f, c), faces_(f, (c + 1) % 3));
                visit(faces_(f, c), faces_(f, (c + 2) % 3));
            }
        }
    });
    std::vector<Index> vertices;
    for (Index v = 0; v < rest.rows(); ++v) {
        execution.check_every(v);
        if (faces_at_.of(v).empty()) continue;
        vertices.push_back(v);
        for (const Index f : faces_at_.of(v)) {
            const Vector3 corner = rest.row(faces_(f, 0));
            areas_[v] += (rest.row(faces_(f, 1)).transpose() - corner)
                             .cross(rest.row(faces_(f, 2)).transpose() - corner)
                             .norm();
        }
        for (const Index other : neighbours_.of(v))
            mean_edges_[v] += (rest.row(other) - rest.row(v)).norm();
        mean_edges_[v] /= static_cast<double>(neighbours_.of(v).end() - neighbours_.of(v).begin());
    }
    find_normals(rest.data(), vertices, threads, execution, rest_normals_);
}

void CarrierSurface::find_normals(const double* positions, const std::vector<Index>& vertices, int threads,
                                  const Execution& execution, std::vector<Vector3>& normals) const {
    parallel_for(static_cast<Index>(vertices.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            Vector3 area = Vector3::Zero();
            for (const Index f : faces_at_.of(vertices[k])) {
                const Vector3 corner = point_at(positions, faces_(f, 0));
                area +=
                    (point_at(positions, faces_(f, 1)) - corner).cross(point_at(positions, faces_(f, 2)) - corner);
            }
            normals[vertices[k]] = unit_or_zero(area);
        }
    });
}

SurfacePatch CarrierSurface::patch_at(const double* rest, const SurfacePlace& place, double reach,
                                      Scratch& scratch) const {
    scratch.distances.resize(mean_edges_.size(), kUnreached);
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto reach_to = [&](Index v, double distance) {
        double& known = scratch.distances[v];
        if (!(distance < known) || !(distance < reach)) return;
        if (known == kUnreached) scratch.reached.push_back(v);
        known = distance;
        queue.emplace(distance, v);
    };
    const Vector3 from = place.of(rest);
    for (const Index corner : place.corners)
        reach_to(corner, (point_at(rest, corner) - from).norm());
    for (std::ptrdiff_t walked = 0; !queue.empty();) {
        const auto [distance, v] = queue.top();
        queue.pop();
        if (distance > scratch.distances[v]) continue;
        if (++walked > kMostWalked) {
            reach = distance;
            break;
        }
        const auto around = neighbours_.of(v);
        if (around.end() - around.begin() > kMostWalked) continue;  // as the hub of a fan
        for (const Index other : around)
            reach_to(other, distance + (point_at(rest, other) - point_at(rest, v)).norm());
    }
    std::vector<Entry> found;
    for (const Index v : scratch.reached) {
        const double distance = std::exchange(scratch.distances[v], kUnreached);
        if (!(distance < reach)) continue;
        const double fade = 1.0 - distance / reach * (distance / reach);
        found.emplace_back(areas_[v] * fade * fade, v);
    }
    scratch.reached.clear();
    // The lower number first of equal ones.
    const auto is_before = [](const Entry& a, const Entry& b) {
        return a.first != b.first ? a.first > b.first : a.second < b.second;
    };
    const std::size_t kept = std::min<std::size_t>(found.size(), SurfacePatch::kMost + 1);
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(), is_before);
    const double dropped = kept > SurfacePatch::kMost ? kDropped * found[SurfacePatch::kMost].first : 0.0;
    found.resize(std::min<std::size_t>(kept, SurfacePatch::kMost));
    double sum = 0.0;
    for (Entry& entry : found)
        sum += entry.first -= dropped;
    if (!(sum > 0.0)) {  // no area, or nothing within reach
        found.clear();
        sum = 1.0;
        for (int c = 0; c < 3; ++c)
            found.emplace_back(place.weights[c], place.corners[c]);
    }
    SurfacePatch patch;
    patch.count = static_cast<int>(found.size());
    Vector3 centre = Vector3::Zero();  // from the place
    Vector3 normal = Vector3::Zero();
    for (int k = 0; k < patch.count; ++k) {
        patch.points[k] = found[k].second;
        patch.weights[k] = found[k].first / sum;
        centre += patch.weights[k] * (point_at(rest, patch.points[k]) - from);
        normal += patch.weights[k] * rest_normals_[patch.points[k]];
    }
    double square = 0.0;
    for (int k = 0; k < patch.count; ++k) {
        const Vector3 arm = point_at(rest, patch.points[k]) - from - centre;
        square += patch.weights[k] * arm.squaredNorm();
        patch.arms[k] = patch.weights[k] * arm;
    }
    patch.normal = 0.5 * square * unit_or_zero(normal);
    return patch;
}

}  // namespace meanvalue
