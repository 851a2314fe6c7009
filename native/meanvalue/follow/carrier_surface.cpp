#include "meanvalue/follow/carrier_surface.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace meanvalue {
namespace {

constexpr std::size_t kMostPoints = 8;
// Of what is dropped from a patch: not all of it, or patches of equal weights would have none.
constexpr double kDropped = 0.999;
// Beside edges that are far longer than others a patch would go on through all of the mesh.
constexpr std::size_t kMostReached = 512;
// So many edges stand for all.
constexpr std::size_t kMostEdges = 2048;
// Faces of a surface modeled from both sides cancel each other: what is left by rounding is no normal.
constexpr double kCancelled = 1e-12;
// What shrinks to a point keeps this much of its size.
constexpr double kLeastGrowth = 1e-9;

Triangles faces_of(const TrianglesView& faces, const std::vector<Index>& part_of,
                   const std::vector<char>& is_carrier) {
    std::vector<Index> chosen;
    for (Index f = 0; f < faces.rows(); ++f) {
        if (is_carrier[part_of[faces(f, 0)]]) chosen.push_back(f);
    }
    return faces(chosen, Eigen::all);
}

}  // namespace

Vector3 SurfacePlace::of(const double* positions) const {
    const Vector3 first = point_at(positions, corners[0]);
    return first + weights[1] * (point_at(positions, corners[1]) - first) +
           weights[2] * (point_at(positions, corners[2]) - first);
}

Vector3 SurfacePlace::normal(const std::vector<Vector3>& normals) const {
    return (weights[0] * normals[corners[0]] + weights[1] * normals[corners[1]] + weights[2] * normals[corners[2]])
        .normalized();
}

SurfacePlace place_on(const TriangleTree& tree, const TriangleTree::Place& found) {
    const auto corners = tree.triangles().row(found.triangle);
    return {{corners[0], corners[1], corners[2]}, found.weights};
}

SurfacePatch::SurfacePatch(const std::vector<std::pair<double, Index>>& weighted, const double* rest,
                           const std::vector<Vector3>& normals) {
    double sum = 0.0;
    for (const auto& [weight, v] : weighted)
        sum += weight;
    for (const auto& [weight, v] : weighted)
        points.push_back({v, weight / sum, Vector3::Zero()});
    const Vector3 middle = centre(rest);
    double square = 0.0;
    for (Point& point : points) {
        const Vector3 arm = point_at(rest, point.vertex) - middle;
        point.arm = point.weight * arm;
        square += point.weight * arm.squaredNorm();
        if (!normals.empty()) normal += point.weight * normals[point.vertex];
    }
    normal = 0.5 * square * normal.normalized();
}

Vector3 SurfacePatch::centre(const double* positions) const {
    const Vector3 first = point_at(positions, points.front().vertex);
    Vector3 offset = Vector3::Zero();
    for (const Point& point : points)
        offset += point.weight * (point_at(positions, point.vertex) - first);
    return first + offset;
}

Matrix3 SurfacePatch::covariance(const double* positions, const std::vector<Vector3>& normals) const {
    const Vector3 origin = point_at(positions, points.front().vertex);  // any would do: arms have the sum zero
    Vector3 posed_normal = Vector3::Zero();
    Matrix3 result = Matrix3::Zero();
    for (const Point& point : points) {
        result.noalias() += (point_at(positions, point.vertex) - origin) * point.arm.transpose();
        if (!normals.empty()) posed_normal += point.weight * normals[point.vertex];
    }
    return result + posed_normal.normalized() * normal.transpose();
}

void RestEdges::add(Index a, Index b, const double* rest) {
    const double length = (point_at(rest, a) - point_at(rest, b)).norm();
    if (length > 0.0) edges.push_back({a, b, length});
}

double RestEdges::growth(const double* positions) const {
    std::vector<double> ratios;
    for (std::size_t k = 0; k < edges.size(); k += 1 + edges.size() / kMostEdges)
        ratios.push_back((point_at(positions, edges[k].a) - point_at(positions, edges[k].b)).norm() /
                         edges[k].length);
    if (ratios.empty()) return 1.0;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::max(*middle, kLeastGrowth);
}

CarrierSurface::CarrierSurface(const PositionsView& rest, const TrianglesView& faces,
                               const std::vector<Index>& part_of, const std::vector<char>& is_carrier,
                               const Execution& execution)
    : rest_(rest),
      tree_(rest, faces_of(faces, part_of, is_carrier), part_of, execution),
      normals_(rest.rows()),
      areas_(rest.rows()),
      mean_edges_(rest.rows(), 0.0) {
    fans_ = grouped<Index>(rest.rows(), [&](const auto& visit) {
        execution.check();
        for (Index f = 0; f < tree_.triangles().rows(); ++f) {
            const auto corners = tree_.triangles().row(f);
            for (int c = 0; c < 3; ++c) {
                visit(corners[c], corners[(c + 1) % 3]);
                visit(corners[c], corners[(c + 2) % 3]);
            }
        }
    });
    for (Index v = 0; v < rest.rows(); ++v) {
        execution.check_every(v);
        const Vector3 area = area_around(fans_, rest.data(), v);
        normals_[v] = area.normalized();
        for (const Index other : fans_.of(v))
            mean_edges_[v] += (rest.row(other) - rest.row(v)).norm() / fans_.of(v).size();
        areas_[v] = area.isZero(0.0) ? mean_edges_[v] * mean_edges_[v] : area.norm();
    }
}

SurfacePlace CarrierSurface::nearest(const Vector3& point) const {
    return place_on(tree_, tree_.nearest({point}, std::numeric_limits<double>::infinity()));
}

SurfacePatch CarrierSurface::patch_at(const SurfacePlace& place, double reach, Index mark,
                                      std::vector<Index>& reached) const {
    const Vector3 from = place.of(rest_.data());
    std::vector<std::pair<double, Index>> found;
    const auto reach_to = [&](Index v) {
        if (std::exchange(reached[v], mark) == mark) return;
        const double share = (point_at(rest_.data(), v) - from).norm() / reach;
        if (!(share < 1.0) || found.size() >= kMostReached) return;
        const double fade = 1.0 - share * share;
        found.emplace_back(areas_[v] * fade * fade, v);
    };
    for (const Index corner : place.corners)
        reach_to(corner);
    for (std::size_t k = 0; k < found.size(); ++k) {
        const auto around = fans_.of(found[k].second);
        if (static_cast<std::size_t>(around.size()) > kMostReached) continue;  // as the hub of a fan
        std::for_each(around.begin(), around.end(), reach_to);
    }
    const std::size_t kept = std::min(found.size(), kMostPoints + 1);
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(),
                      std::greater<>());
    found.resize(kept);
    if (kept > kMostPoints) {
        for (auto& [weight, v] : found)
            weight -= kDropped * found.back().first;
        found.pop_back();
    }
    if (found.empty() || !(found.front().first > 0.0)) {  // no area, or nothing within reach
        found.clear();
        for (int c = 0; c < 3; ++c)
            found.emplace_back(place.weights[c], place.corners[c]);
    }
    return {found, rest_.data(), normals_};
}

Vector3 area_around(const Grouped<Index>& fans, const double* positions, Index v) {
    const auto around = fans.of(v);
    const Vector3 point = point_at(positions, v);
    Vector3 area = Vector3::Zero();
    double squares = 0.0;
    for (const Index* next = around.begin(); next != around.end(); next += 2) {
        const Vector3 face = (point_at(positions, next[0]) - point).cross(point_at(positions, next[1]) - point);
        area += face;
        squares += face.squaredNorm();
    }
    return area.squaredNorm() > kCancelled * squares ? area : Vector3::Zero();
}

}  // namespace meanvalue
