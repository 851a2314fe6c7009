#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

/// `point`, which is at rest, by the similarity that takes the ring nearest to where it is. For every vertex of a
/// cold solve: fit_similarity() would take several times as long, and shrink what is bent.
Vector3 carried(const Index* ring, std::size_t valence, const Vector3& point, const PositionsView& rest,
                const PositionsView& positions) {
    const Correlation sums = correlate(rest, positions, ring, valence);
    const double scale = sums.from_spread > 0.0 ? std::sqrt(sums.to_spread / sums.from_spread) : 1.0;
    return sums.to_centre + closest_rotation(sums.covariance) * (scale * (point - sums.from_centre));
}

/// Calls place(vertex) for one batch after another: they read what earlier batches have placed.
template <typename Place>
void for_each_in_batches(const Splits& splits, int threads, const Execution& execution, const Place& place) {
    for (std::size_t batch = 0; batch + 1 < splits.batches.size(); ++batch) {
        const Index first = splits.batches[batch];
        parallel_for(splits.batches[batch + 1] - first, threads, execution, [&](Index begin, Index end) {
            for (Index k = first + begin; k < first + end; ++k)
                place(splits.vertices[k]);
        });
    }
}

}  // namespace

void Splits::apply(const Encoding& encoding, Positions& positions, int threads, const Execution& execution) const {
    const PositionsView view(positions);  // sees what is written
    for_each_in_batches(*this, threads, execution,
                        [&](Index v) { positions.row(v) = predict(encoding.ring_of(v), view); });
}

void Splits::carry(const PositionsView& rest, Positions& positions, int threads, const Execution& execution) const {
    const PositionsView view(positions);  // sees what is written
    for_each_in_batches(*this, threads, execution, [&](Index v) {
        positions.row(v) = carried(rings.begin(v), rings.valence(v), rest.row(v), rest, view).transpose();
    });
}

Index Splits::longest_ring() const {
    Index longest = 0;
    for (const Index v : vertices)
        longest = std::max(longest, rings.valence(v));
    return longest;
}

SplitRecorder::SplitRecorder(Index vertex_count) : depth_(vertex_count, 0) {
    // Enough for most meshes, so that it need not be copied while it grows; what stays unused costs nothing.
    vertices_.reserve(vertex_count);
    rings_.reserve(vertex_count);
}

void SplitRecorder::add(Index vertex, const RingView& ring) {
    vertices_.push_back(vertex);
    rings_.append(ring.begin(), ring.end(), ring.closed ? RingKind::kClosed : RingKind::kOpen, ring.closed);
}

Splits SplitRecorder::take(const Execution& execution) {
    Index deepest = 0;
    std::vector<Index> number(depth_.size(), -1);  // of a vertex in `vertices_`
    for (Index k = rings_.vertex_count(); k-- > 0;) {
        execution.check_every(k);
        Index depth = 0;
        for (const Index* v = rings_.begin(k); v != rings_.end(k); ++v)
            depth = std::max(depth, depth_[*v]);
        depth_[vertices_[k]] = depth + 1;
        deepest = std::max(deepest, depth + 1);
        number[vertices_[k]] = k;
    }
    execution.check();
    // In a batch by ascending vertex number: neighbors by number are mostly neighbors in space.
    auto by_depth = grouped<Index>(deepest, [&](const auto& visit) {
        for (std::size_t v = 0; v < depth_.size(); ++v) {
            if (depth_[v] > 0) visit(depth_[v] - 1, static_cast<Index>(v));
        }
    });
    Splits result;
    result.batches.assign(by_depth.offsets.begin(), by_depth.offsets.end());
    result.vertices = std::move(by_depth.items);
    result.rings.reserve(static_cast<Index>(number.size()));
    for (std::size_t v = 0; v < number.size(); ++v) {
        execution.check_every(v);
        const Index k = number[v];
        if (k < 0) {
            result.rings.append(nullptr, nullptr, RingKind::kAbsent, false);
        } else {
            result.rings.append(rings_.begin(k), rings_.end(k), rings_.kinds[k], rings_.closed[k] != 0);
        }
    }
    // Coarser levels count from the bottom again: what is placed there is given here.
    std::fill(depth_.begin(), depth_.end(), 0);
    rings_ = OneRings();
    vertices_.clear();
    return result;
}

}  // namespace meanvalue
