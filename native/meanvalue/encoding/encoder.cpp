#include "meanvalue/encoding/encoder.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/ring_encoder.h"

namespace meanvalue {
namespace {

using RingReplacements = std::unordered_map<Index, std::vector<Index>>;

/// Rings for the vertices whose own ring spans no plane; empty ones where no wider ring does either.
RingReplacements replace_degenerate_rings(const OneRings& rings, const PositionsView& positions, int threads,
                                          const Execution& execution) {
    std::vector<char> degenerate(rings.vertex_count(), 0);
    parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            degenerate[v] =
                rings.valence(v) > 0 && !spans_a_plane(positions, rings.begin(v), rings.valence(v)) ? 1 : 0;
        }
    });
    RingReplacements replacements;
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        if (!degenerate[v]) continue;
        execution.check();
        replacements.emplace(v, extended_ring(positions, rings, v));
    }
    return replacements;
}

Encoding lay_out_rings(const OneRings& rings, const RingReplacements& replacements, bool with_cotangents,
                       const Execution& execution) {
    Encoding encoding;
    encoding.ring_offsets.reserve(rings.vertex_count() + 1);
    encoding.ring_offsets.push_back(0);
    encoding.ring.reserve(rings.vertices.size());
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        execution.check_every(v);
        const auto replacement = replacements.find(v);
        if (replacement == replacements.end()) {
            encoding.ring.insert(encoding.ring.end(), rings.begin(v), rings.end(v));
        } else {
            encoding.ring.insert(encoding.ring.end(), replacement->second.begin(), replacement->second.end());
        }
        encoding.ring_offsets.push_back(static_cast<Index>(encoding.ring.size()));
    }
    for (std::vector<double>* numbers : {&encoding.weights, &encoding.heights})
        numbers->resize(encoding.ring.size());
    encoding.softening.assign(rings.vertex_count(), 0.0);
    encoding.steep_offset.assign(rings.vertex_count(), -1);
    if (with_cotangents) encoding.cotangents.resize(encoding.ring.size());
    return encoding;
}

/// Fills the coefficients of one vertex whose ring is laid out; returns its GuardReason flags.
std::uint8_t encode_vertex(RingEncoder& encoder, Index vertex, Encoding& encoding) {
    if (!encoding.predictable(vertex)) return kNotPredictable;
    const Index begin = encoding.ring_offsets[vertex];
    const Index valence = encoding.ring_offsets[vertex + 1] - begin;
    const std::uint8_t flags = encoder.encode(vertex, encoding.ring.data() + begin, valence);
    if ((flags & kNotPredictable) != 0) return flags;
    std::copy_n(encoder.weights().begin(), valence, encoding.weights.begin() + begin);
    if (!encoding.cotangents.empty())
        std::copy_n(encoder.cotangents().begin(), valence, encoding.cotangents.begin() + begin);
    std::copy_n(encoder.heights().begin(), valence, encoding.heights.begin() + begin);
    encoding.softening[vertex] = encoder.softening();
    return flags;
}

}  // namespace

Encoding encode(const OneRings& rings, const PositionsView& positions, int threads, Execution& execution,
                bool with_cotangents) {
    execution.begin_stage("encode");
    RingReplacements replacements = replace_degenerate_rings(rings, positions, threads, execution);
    Encoding encoding;
    std::vector<std::uint8_t> flags;
    for (bool is_done = false; !is_done;) {
        encoding = lay_out_rings(rings, replacements, with_cotangents, execution);
        flags.assign(rings.vertex_count(), 0);
        parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
            RingEncoder encoder(positions);
            for (Index v = begin; v < end; ++v) {
                if (rings.kinds[v] != RingKind::kAbsent) flags[v] = encode_vertex(encoder, v, encoding);
            }
        });
        // Rings that could not be encoded become empty ones, so that predictable() tells. They are rare.
        is_done = true;
        for (Index v = 0; v < rings.vertex_count(); ++v) {
            if ((flags[v] & kNotPredictable) == 0 || !encoding.predictable(v)) continue;
            replacements[v].clear();
            is_done = false;
        }
    }
    RingEncoder encoder(positions);
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        execution.check_every(v);
        if (rings.kinds[v] == RingKind::kNonManifold) flags[v] |= kNonManifold;
        if (encoding.predictable(v) && replacements.count(v) > 0) flags[v] |= kExtendedRing;
        if (flags[v] == 0) continue;
        if ((flags[v] & kSteepEdge) != 0) {  // their offsets depend on those before; there are few
            encode_vertex(encoder, v, encoding);
            encoding.steep_offset[v] = static_cast<Index>(encoding.steep_weights.size());
            const std::vector<double> steep = encoder.steep_weights();
            encoding.steep_weights.insert(encoding.steep_weights.end(), steep.begin(), steep.end());
        }
        encoding.guarded.push_back(v);
        encoding.guard_reasons.push_back(flags[v]);
    }
    execution.set_progress(1.0);
    return encoding;
}

}  // namespace meanvalue
