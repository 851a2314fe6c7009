#include "meanvalue/decode/fast/rest_cells.h"

#include <cmath>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

/// From the world to the cell's frame. Where the edges span no plane any frame will do.
Matrix3 frame_of(const Vector3* edges, Index count) {
    Vector3 area = Vector3::Zero();
    for (Index k = 0; k < count; ++k)
        area += edges[k].cross(edges[k + 1 == count ? 0 : k + 1]);
    const double length = area.norm();
    if (!(length > 0.0) || !std::isfinite(1.0 / length)) return Matrix3::Identity();
    const Vector3 normal = area / length;
    Vector3 across = edges[0] - edges[0].dot(normal) * normal;
    // Relative to the edge itself: along the normal, what is left is rounding.
    const bool is_upright = !(across.norm() > 1e-6 * edges[0].norm());
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

}  // namespace meanvalue
