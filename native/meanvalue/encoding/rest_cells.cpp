#include "meanvalue/encoding/rest_cells.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

// Cotangents are clamped: positive, so that no edge may gain by stretching; finite, where a triangle has no area.
constexpr double kLeastCotangent = 0.05;
constexpr double kMostCotangent = 1.0 / kLeastCotangent;
// Each triangle's half cotangent, scaled to make an edge between equilateral triangles 1.
constexpr double kCotangentScale = 0.86602540378443865;

// How many times rigidity counts in a row: the least, where the shape is flat at rest; what is added for each unit of
// its mean curvature at rest, (1/r1 + 1/r2) D; and the most, reached by limbs of radius D/100. The thinner a limb,
// the less its strain costs beside its curvature, and it rolls about its axis: docs/decisions/0007-rigidity.md.
constexpr double kLeastRigidity = 0.8;
constexpr double kRigidityByCurvature = 0.016;
constexpr double kMostRigidity = 2.4;

Index next_of(Index k, Index valence) {
    return k + 1 == valence ? 0 : k + 1;
}

/// @param sine, cosine of an angle, both times the product of the lengths of its sides.
double cotangent_weight(double sine, double cosine) {
    const double cotangent = sine * kMostCotangent > cosine ? cosine / sine : kMostCotangent;
    return kCotangentScale * std::max(cotangent, kLeastCotangent);
}

/// From the world to the cell's frame. Where the edges span no plane any frame will do.
Matrix3 frame_of(const Vector3* edges, Index count) {
    Vector3 area = Vector3::Zero();
    for (Index k = 0; k < count; ++k)
        area += edges[k].cross(edges[next_of(k, count)]);
    const double length = area.norm();
    if (!(length > 0.0) || !std::isfinite(1.0 / length)) return Matrix3::Identity();
    const Vector3 normal = area / length;
    Vector3 across = edges[0] - edges[0].dot(normal) * normal;
    // Relative to the edge itself: along the normal, what is left is rounding.
    const bool is_upright = !(across.norm() > kCoincident * edges[0].norm());
    across = is_upright ? normal.unitOrthogonal() : across.normalized();
    Matrix3 frame;
    frame << across.transpose(), normal.cross(across).transpose(), normal.transpose();
    return frame;
}

}  // namespace

double RestCells::mean_edge(const Encoding& encoding, Index vertex) const {
    const Index first = encoding.ring_offsets[vertex];
    const Index count = encoding.ring_offsets[vertex + 1] - first;
    double length = 0.0;
    for (Index k = 0; k < count; ++k)
        length += edges[first + k].norm();
    return count > 0 ? length / count : 0.0;
}

RestCells rest_cells(const Encoding& encoding, const PositionsView& rest, int threads, const Execution& execution) {
    RestCells cells;
    cells.edges.resize(encoding.ring.size());
    const auto count = static_cast<Index>(encoding.ring_offsets.size()) - 1;
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const Index first = encoding.ring_offsets[v];
            const Index valence = encoding.ring_offsets[v + 1] - first;
            if (valence == 0) continue;
            Vector3* const edges = cells.edges.data() + first;
            for (Index k = 0; k < valence; ++k)
                edges[k] = (rest.row(v) - rest.row(encoding.ring[first + k])).transpose();
            const Matrix3 frame = frame_of(edges, valence);
            for (Index k = 0; k < valence; ++k)
                edges[k] = frame * edges[k];
        }
    });
    return cells;
}

double measure_spokes(const Vector3* edges, Index valence, Spoke* spokes) {
    double length = 0.0;
    for (Index k = 0; k < valence; ++k) {
        spokes[k] = {edges[k], 0.0, 0.0};
        length += edges[k].norm();
    }
    for (Index k = 0; k < valence; ++k) {
        // The triangle of i and the ring's k and next; where an open ring is closed by its chord, that too.
        Spoke& here = spokes[k];
        Spoke& next = spokes[next_of(k, valence)];
        const double area = here.rest.cross(next.rest).norm();  // twice: the same at all three corners
        const Vector3 rim = next.rest - here.rest;
        here.rim = cotangent_weight(area, here.rest.dot(next.rest));
        here.spoke += cotangent_weight(area, next.rest.dot(rim));
        next.spoke += cotangent_weight(area, -here.rest.dot(rim));
    }
    return length / valence;
}

double rigidity_of_cell(const Vector3* edges, Index valence, double size) {
    Vector3 area = Vector3::Zero();
    Vector3 sum = Vector3::Zero();
    double squares = 0.0;
    for (Index k = 0; k < valence; ++k) {
        area += edges[k].cross(edges[next_of(k, valence)]);
        sum += edges[k];
        squares += edges[k].squaredNorm();
    }
    // A sphere's vertex lies |e|^2 / 2r over a neighbor: their sum is that of the squares times (1/r1 + 1/r2) / 4.
    const double scale = area.norm() * squares;
    const double curvature = scale > 0.0 ? 4.0 * std::abs(area.dot(sum)) / scale : 0.0;
    return std::min(kLeastRigidity + kRigidityByCurvature * curvature * size, kMostRigidity);
}

}  // namespace meanvalue
