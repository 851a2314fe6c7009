#include "meanvalue/encoding/blend.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/projection_plane.h"

namespace meanvalue {
namespace {

// Below it a height tells nothing of its angle.
constexpr double kLeastWeight = 1e-9;
// Angles of averages stay so far from 0 and pi, also where weights exaggerate: cotangents below 40.
constexpr double kLeastAngle = 0.025;
constexpr double kPi = 3.14159265358979323846;

void require_same_layout(const Encoding& first, const Encoding& other, std::size_t number) {
    if (first.vertex_count() != other.vertex_count()) {
        throw InvalidInput(message("encoding ", number, " has ", other.vertex_count(),
                                   " vertices, but encoding 0 has ", first.vertex_count(),
                                   "; only shapes of one mesh can be blended"));
    }
    for (Index v = 0; v < first.vertex_count(); ++v) {
        const EncodedRing a = first.ring_of(v);
        const EncodedRing b = other.ring_of(v);
        if (a.valence == b.valence && std::equal(a.ring, a.ring + a.valence, b.ring) &&
            (a.normal_weights == nullptr) == (b.normal_weights == nullptr))
            continue;
        throw InvalidInput(message("encodings 0 and ", number, " have other rings at vertex ", v,
                                   "; give shapes of one mesh, encoded together by encode_alike()"));
    }
}

/// The angle whose cotangent the predictor multiplies lengths with.
double angle_of(const Encoding& encoding, std::size_t place) {
    const double weight = encoding.weights[place];
    const double cotangent = std::abs(weight) > kLeastWeight ? encoding.heights[place] / weight
                                                             : encoding.cotangents[place] / kRestNormalLength;
    return arc_tangent(1.0, cotangent);
}

/// @param value_of called with each encoding.
template <typename Value>
double average(const std::vector<const Encoding*>& encodings, const double* weights, const Value& value_of) {
    double sum = 0.0;
    for (std::size_t k = 0; k < encodings.size(); ++k)
        sum += weights[k] * value_of(*encodings[k]);
    return sum;
}

void blend_vertex(const std::vector<const Encoding*>& encodings, Index vertex, const double* weights,
                  Encoding& result) {
    const auto mean = [&](const auto& value_of) { return average(encodings, weights, value_of); };
    result.softening[vertex] = std::max(0.0, mean([&](const Encoding& of) { return of.softening[vertex]; }));
    const Index begin = result.ring_offsets[vertex];
    const Index steep = result.steep_offset[vertex];
    for (Index place = begin; place < result.ring_offsets[vertex + 1]; ++place) {
        result.weights[place] = mean([&](const Encoding& of) { return of.weights[place]; });
        if (steep >= 0) {
            const Index own = steep + place - begin;
            const double share = mean([&](const Encoding& of) { return of.steep_weights[own]; });
            result.steep_weights[own] = share;
            result.heights[place] = mean([&](const Encoding& of) { return of.heights[place]; });
            result.cotangents[place] = share > kLeastWeight ? result.heights[place] / share * kRestNormalLength : 0.0;
            continue;
        }
        const double angle = mean([&](const Encoding& of) { return angle_of(of, place); });
        const auto [sine, cosine] = sine_cosine(std::clamp(angle, kLeastAngle, kPi - kLeastAngle));
        result.heights[place] = result.weights[place] * cosine / sine;
        result.cotangents[place] = cosine / sine * kRestNormalLength;
    }
}

}  // namespace

Encoding blend(const std::vector<const Encoding*>& encodings, const ShapeWeights& weights, int threads,
               const Execution& execution) {
    if (encodings.empty()) throw InvalidInput("there are no encodings to blend; give one or more");
    for (std::size_t k = 1; k < encodings.size(); ++k) {
        execution.check();
        require_same_layout(*encodings.front(), *encodings[k], k);
    }
    Encoding result = *encodings.front();
    parallel_for(result.vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            blend_vertex(encodings, v, weights.of(v), result);
    });
    return result;
}

}  // namespace meanvalue
