#include "meanvalue/encoding/blend.h"

#include <algorithm>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

void require_same_rings(const Encoding& first, const Encoding& other, std::size_t number) {
    if (first.vertex_count() != other.vertex_count()) {
        throw InvalidInput(message("encoding ", number, " has ", other.vertex_count(),
                                   " vertices, but encoding 0 has ", first.vertex_count(),
                                   "; only shapes of one mesh can be blended"));
    }
    for (Index v = 0; v < first.vertex_count(); ++v) {
        const EncodedRing a = first.ring_of(v);
        const EncodedRing b = other.ring_of(v);
        if (a.valence == b.valence && std::equal(a.ring, a.ring + a.valence, b.ring)) continue;
        throw InvalidInput(message("encodings 0 and ", number, " have other rings at vertex ", v,
                                   "; give shapes of one mesh whose triangles there have an area, or mix the shapes ",
                                   "with a Morpher"));
    }
}

}  // namespace

Encoding blend(const std::vector<const Encoding*>& encodings, const ShapeWeights& weights, int threads,
               const Execution& execution) {
    if (encodings.empty()) throw InvalidInput("there are no encodings to blend; give one or more");
    for (std::size_t k = 1; k < encodings.size(); ++k) {
        execution.check();
        require_same_rings(*encodings.front(), *encodings[k], k);
    }
    Encoding result = *encodings.front();
    const bool has_cotangents =
        std::none_of(encodings.begin(), encodings.end(), [](const Encoding* of) { return of->cotangents.empty(); });
    if (!has_cotangents) result.cotangents.clear();
    result.steep_weights.clear();
    for (Index v = 0; v < result.vertex_count(); ++v) {
        const bool is_steep = std::any_of(encodings.begin(), encodings.end(),
                                          [v](const Encoding* of) { return of->steep_offset[v] >= 0; });
        result.steep_offset[v] = is_steep ? static_cast<Index>(result.steep_weights.size()) : -1;
        if (is_steep) result.steep_weights.resize(result.steep_weights.size() + result.ring_of(v).valence);
    }
    parallel_for(result.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const auto mean = [&](const auto& value_of) {
                double sum = 0.0;
                for (std::size_t k = 0; k < encodings.size(); ++k)
                    sum += weights.of(v)[k] * value_of(*encodings[k]);
                return sum;
            };
            const Index first = result.ring_offsets[v];
            const Index steep = result.steep_offset[v];
            result.softening[v] = std::max(0.0, mean([&](const Encoding& of) { return of.softening[v]; }));
            for (Index place = first; place < result.ring_offsets[v + 1]; ++place) {
                result.weights[place] = mean([&](const Encoding& of) { return of.weights[place]; });
                result.heights[place] = mean([&](const Encoding& of) { return of.heights[place]; });
                if (has_cotangents)
                    result.cotangents[place] = mean([&](const Encoding& of) { return of.cotangents[place]; });
                if (steep < 0) continue;
                // A ring that is not steep has u_ij = w_ij.
                result.steep_weights[steep + place - first] = mean([&](const Encoding& of) {
                    const EncodedRing ring = of.ring_of(v);
                    return (ring.normal_weights == nullptr ? ring.weights : ring.normal_weights)[place - first];
                });
            }
        }
    });
    return result;
}

}  // namespace meanvalue
