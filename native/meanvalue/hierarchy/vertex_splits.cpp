#include "meanvalue/hierarchy/vertex_splits.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/linalg/closest_rotation.h"
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

/// Calls place(k) for the splits of one batch after another: they read what earlier batches have placed.
template <typename Place>
void for_each_in_batches(const std::vector<Index>& batches, int threads, const Execution& execution,
                         const Place& place) {
    for (std::size_t batch = 0; batch + 1 < batches.size(); ++batch) {
        const Index first = batches[batch];
        parallel_for(batches[batch + 1] - first, threads, execution, [&](Index begin, Index end) {
            for (Index k = first + begin; k < first + end; ++k)
                place(k);
        });
    }
}

}  // namespace

EncodedRing Splits::ring_of(Index split) const {
    const std::size_t begin = offsets[split];
    return {ring.data() + begin,    weights.data() + begin,
            heights.data() + begin, nullptr,
            softening[split],       static_cast<Index>(offsets[split + 1] - begin)};
}

void Splits::encode(const PositionsView& positions, int threads, const Execution& execution) {
    weights.resize(ring.size());
    heights.resize(ring.size());
    softening.resize(vertices.size());
    parallel_for(size(), threads, execution, [&](Index begin, Index end) {
        RingEncoder encoder(positions);
        for (Index k = begin; k < end; ++k) {
            const std::size_t first = offsets[k];
            encoder.encode(vertices[k], ring.data() + first, static_cast<Index>(offsets[k + 1] - first));
            std::copy(encoder.weights().begin(), encoder.weights().end(), weights.begin() + first);
            std::copy(encoder.heights().begin(), encoder.heights().end(), heights.begin() + first);
            softening[k] = encoder.softening();
        }
    });
}

void Splits::apply(Positions& positions, int threads, const Execution& execution) const {
    const PositionsView view(positions);  // sees what is written
    for_each_in_batches(batches, threads, execution,
                        [&](Index k) { positions.row(vertices[k]) = predict(ring_of(k), view); });
}

void Splits::carry(const PositionsView& rest, Positions& positions, int threads, const Execution& execution) const {
    const PositionsView view(positions);  // sees what is written
    for_each_in_batches(batches, threads, execution, [&](Index k) {
        positions.row(vertices[k]) =
            carried(ring.data() + offsets[k], offsets[k + 1] - offsets[k], rest.row(vertices[k]), rest, view)
                .transpose();
    });
}

Index Splits::longest_ring() const {
    std::size_t longest = 0;
    for (Index k = 0; k < size(); ++k)
        longest = std::max(longest, offsets[k + 1] - offsets[k]);
    return static_cast<Index>(longest);
}

SplitRecorder::SplitRecorder(Index vertex_count) : depth_(vertex_count, 0) {
    // Enough for most meshes, so that it need not be copied while it grows; what stays unused costs nothing.
    // Rings have six vertices on average, since edges are three times as many as vertices.
    const auto count = static_cast<std::size_t>(vertex_count);
    taken_.vertices.reserve(count);
    taken_.offsets.reserve(count + 1);
    taken_.closed.reserve(count);
    taken_.ring.reserve(6 * count);
}

void SplitRecorder::add(Index vertex, const RingView& ring) {
    taken_.vertices.push_back(vertex);
    taken_.ring.insert(taken_.ring.end(), ring.begin(), ring.end());
    taken_.offsets.push_back(taken_.ring.size());
    taken_.closed.push_back(ring.closed ? 1 : 0);
}

Splits SplitRecorder::take(int threads, const Execution& execution) {
    const Index count = taken_.size();
    Index deepest = 0;
    for (Index k = count; k-- > 0;) {
        execution.check_every(k);
        Index depth = 0;
        for (std::size_t j = taken_.offsets[k]; j < taken_.offsets[k + 1]; ++j)
            depth = std::max(depth, depth_[taken_.ring[j]]);
        depth_[taken_.vertices[k]] = depth + 1;
        deepest = std::max(deepest, depth + 1);
    }
    execution.check();
    // In a batch by ascending vertex number: neighbors by number are mostly neighbors in space.
    std::vector<Index> number(depth_.size());  // of a vertex in `taken_`
    for (Index k = 0; k < count; ++k)
        number[taken_.vertices[k]] = k;
    const auto by_depth = grouped<Index>(deepest, [&](const auto& visit) {
        for (std::size_t vertex = 0; vertex < depth_.size(); ++vertex) {
            if (depth_[vertex] > 0) visit(depth_[vertex] - 1, number[vertex]);
        }
    });
    const std::vector<Index>& source = by_depth.items;
    Splits sorted;
    sorted.batches.assign(by_depth.offsets.begin(), by_depth.offsets.end());
    sorted.vertices.resize(count);
    sorted.closed.resize(count);
    sorted.offsets.resize(count + 1);
    for (Index k = 0; k < count; ++k) {
        sorted.offsets[k + 1] = sorted.offsets[k] + taken_.offsets[source[k] + 1] - taken_.offsets[source[k]];
    }
    sorted.ring.resize(taken_.ring.size());
    parallel_for(count, threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index from = source[k];
            const std::size_t first = taken_.offsets[from];
            const std::size_t valence = taken_.offsets[from + 1] - first;
            sorted.vertices[k] = taken_.vertices[from];
            sorted.closed[k] = taken_.closed[from];
            std::copy_n(taken_.ring.data() + first, valence, sorted.ring.data() + sorted.offsets[k]);
        }
    });
    // Coarser levels count from the bottom again: what is placed there is given here.
    for (const Index v : taken_.vertices)
        depth_[v] = 0;
    taken_ = Splits{};
    return sorted;
}

}  // namespace meanvalue
