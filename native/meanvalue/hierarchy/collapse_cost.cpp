#include "meanvalue/hierarchy/collapse_cost.h"

#include <algorithm>
#include <cmath>

namespace meanvalue {
namespace {

// The angle below which triangles become expensive, and the one below which a collapse is put off (radians).
constexpr double kComfortableAngle = 20.0 * 3.14159265358979323846 / 180.0;
constexpr double kNeedleAngle = 1.0 * 3.14159265358979323846 / 180.0;
// Cosine of 78 degrees: a normal that turns farther counts as turned over.
constexpr double kTurnedOver = 0.2;
// Orders regions that are flat, where no volume changes, by edge length.
constexpr double kLengthShare = 1e-3;

/// The smallest angle of a triangle, in radians; 0 for a degenerate one.
double smallest_angle(const Vector3& a, const Vector3& b, const Vector3& c) {
    const double doubled_area = (b - a).cross(c - a).norm();
    const auto angle_at = [&](const Vector3& corner, const Vector3& p, const Vector3& q) {
        return std::atan2(doubled_area, (p - corner).dot(q - corner));
    };
    return std::min({angle_at(a, b, c), angle_at(b, c, a), angle_at(c, a, b)});
}

}  // namespace

double collapse_cost(const PositionsView& positions, Index from, Index to, const Fan& fan) {
    const Vector3 removed = positions.row(from);
    const Vector3 kept = positions.row(to);
    double squared_volumes = 0.0;
    double angle_rad = kComfortableAngle * 3;  // no triangle of a mesh has three angles above 60 degrees
    bool turned_over = false;
    const std::size_t count = fan.ring.size();
    for (std::size_t k = 0; k + (fan.closed ? 0 : 1) < count; ++k) {
        const Index first = fan.ring[k];
        const Index second = fan.ring[(k + 1) % count];
        if (first == to || second == to) continue;
        const Vector3 a = positions.row(first);
        const Vector3 b = positions.row(second);
        const double volume = (a - kept).cross(b - kept).dot(removed - kept) / 6.0;
        squared_volumes += volume * volume;
        angle_rad = std::min(angle_rad, smallest_angle(kept, a, b));
        const Vector3 before = (a - removed).cross(b - removed);
        const Vector3 after = (a - kept).cross(b - kept);
        turned_over = turned_over || before.dot(after) < kTurnedOver * before.norm() * after.norm();
    }
    const double length = (removed - kept).norm();
    const double volume_part = std::sqrt(squared_volumes) + kLengthShare * length * length * length;
    const double angle_ratio = kComfortableAngle / std::max(angle_rad, kNeedleAngle);
    const double cost = volume_part * (1.0 + angle_ratio * angle_ratio);
    return turned_over || angle_rad < kNeedleAngle ? kPutOff * cost : cost;
}

}  // namespace meanvalue
