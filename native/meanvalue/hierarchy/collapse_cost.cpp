#include <algorithm>
#include <cmath>

#include "meanvalue/hierarchy/coarsening.h"

namespace meanvalue {
namespace {

// Of the angle below which triangles become expensive: tan 20 degrees, squared.
constexpr double kSquaredTangent = 0.36397023426620234 * 0.36397023426620234;
// Cosine of 78 degrees: a normal that turns farther counts as turned over.
constexpr double kTurnedOver = 0.2;
// Orders regions that are flat, where no volume changes, by edge length.
constexpr double kLengthShare = 1e-3;
// No triangle has three angles above 60 degrees, whose cotangent is the root of a third: the factor of the angle is
// at least this.
constexpr double kLeastAngleFactor = 1.0 + kSquaredTangent / 3.0;

}  // namespace

void CollapseCost::set_vertex(Index vertex, const RingView& ring) {
    ring_ = ring;
    corners_.resize(ring.valence);
    squared_distance_.resize(ring.valence);
    const Vector3 centre = positions_.row(vertex);
    for (Index k = 0; k < ring.valence; ++k)
        corners_[k].ring_vertex = Vector3(positions_.row(ring.vertices[k])) - centre;
    for (Index k = 0; k < ring.triangle_count(); ++k) {
        Corner& corner = corners_[k];
        const Vector3& next = corners_[k + 1 < ring.valence ? k + 1 : 0].ring_vertex;
        corner.edge = next - corner.ring_vertex;
        corner.area = corner.ring_vertex.cross(next);
        corner.squared_edge = corner.edge.squaredNorm();
        corner.squared_area = corner.area.squaredNorm();
    }
}

double CollapseCost::of(Index place, double limit) const {
    // With the removed vertex as the origin, the tetrahedron between a triangle before and after is
    // kept . (a x b) / 6, and the doubled area after is a x b - kept x (b - a).
    const Vector3& kept = corners_[place].ring_vertex;
    const Index count = ring_.triangle_count();
    const auto next_of = [&](Index k) { return k + 1 < ring_.valence ? k + 1 : 0; };
    const auto closes_up = [&](Index k) { return k != place && next_of(k) != place; };
    double squared_volumes = 0.0;
    for (Index k = 0; k < count; ++k) {
        if (!closes_up(k)) continue;
        const double volume = kept.dot(corners_[k].area);
        squared_volumes += volume * volume;
    }
    const double squared_length = kept.squaredNorm();
    const double volume_part =
        per_unit_ * (std::sqrt(squared_volumes) / 6.0 + kLengthShare * squared_length * std::sqrt(squared_length));
    if (volume_part * kLeastAngleFactor >= limit) return limit;

    for (Index k = 0; k < ring_.valence; ++k)
        squared_distance_[k] = (corners_[k].ring_vertex - kept).squaredNorm();
    // The smallest angle lies opposite the shortest edge; compared by the square of twice its cotangent, which needs
    // no root, as a fraction, which needs no division.
    const double steepest = 4.0 * (limit / volume_part - 1.0) / kSquaredTangent;
    double cotangent_over = 4.0 / 3.0;  // of 60 degrees
    double cotangent_under = 1.0;
    bool turned_over = false;
    for (Index k = 0; k < count; ++k) {
        if (!closes_up(k)) continue;
        const Corner& corner = corners_[k];
        const double first = squared_distance_[k];
        const double second = squared_distance_[next_of(k)];
        const double over =
            first + second + corner.squared_edge - 2.0 * std::min({first, second, corner.squared_edge});
        const Vector3 after = corner.area - kept.cross(corner.edge);
        const double squared_after = after.squaredNorm();
        if (over * over * cotangent_under > cotangent_over * squared_after) {
            cotangent_over = over * over;
            cotangent_under = squared_after;
            if (cotangent_over > steepest * cotangent_under) return limit;
        }
        const double along = corner.area.dot(after);
        turned_over = turned_over || along < 0.0 ||
                      along * along < kTurnedOver * kTurnedOver * corner.squared_area * squared_after;
    }
    const double squared_cotangent =
        std::min(cotangent_over / (4.0 * cotangent_under), 1.0 / (kCoincident * kCoincident));
    const double cost = volume_part * (1.0 + kSquaredTangent * squared_cotangent);
    // One that turns a triangle over is put off until any other costs more.
    return turned_over ? cost / kCoincident : cost;
}

double cost_unit(const OneRings& rings, const PositionsView& positions) {
    double squares = 0.0;
    std::size_t edges = 0;
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        for (const Index* neighbour = rings.begin(v); neighbour != rings.end(v); ++neighbour)
            squares += (positions.row(*neighbour) - positions.row(v)).squaredNorm();
        edges += rings.valence(v);
    }
    const double square = edges > 0 ? squares / static_cast<double>(edges) : 0.0;
    const double unit = square * std::sqrt(square);
    return unit > 0.0 && std::isfinite(1.0 / unit) ? unit : 1.0;
}

}  // namespace meanvalue
