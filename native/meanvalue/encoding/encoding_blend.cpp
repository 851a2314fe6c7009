#include "meanvalue/encoding/encoding_blend.h"

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

double average(const double* values, const double* weights, Index count) {
    double sum = 0.0;
    for (Index k = 0; k < count; ++k)
        sum += weights[k] * values[k];
    return sum;
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& items) {
    return items.capacity() * sizeof(T);
}

}  // namespace

EncodingBlend::EncodingBlend(const std::vector<const Encoding*>& encodings, const Execution& execution)
    : shape_count_(static_cast<Index>(encodings.size())) {
    if (encodings.empty()) throw InvalidInput("there are no encodings to blend; give one or more");
    for (std::size_t k = 1; k < encodings.size(); ++k) {
        execution.check();
        require_same_layout(*encodings.front(), *encodings[k], k);
    }
    layout_ = *encodings.front();
    const std::size_t shapes = encodings.size();
    weights_.resize(layout_.ring.size() * shapes);
    angles_.resize(layout_.ring.size() * shapes);
    softening_.resize(layout_.softening.size() * shapes);
    steep_weights_.resize(layout_.steep_weights.size() * shapes);
    for (std::size_t k = 0; k < shapes; ++k) {
        const Encoding& encoding = *encodings[k];
        for (Index v = 0; v < layout_.vertex_count(); ++v) {
            execution.check_every(v);
            softening_[v * shapes + k] = encoding.softening[v];
            const bool is_steep = layout_.steep_offset[v] >= 0;
            for (std::size_t place = layout_.ring_offsets[v]; place < std::size_t(layout_.ring_offsets[v + 1]);
                 ++place) {
                weights_[place * shapes + k] = encoding.weights[place];
                angles_[place * shapes + k] = is_steep ? encoding.heights[place] : angle_of(encoding, place);
            }
        }
        for (std::size_t place = 0; place < layout_.steep_weights.size(); ++place)
            steep_weights_[place * shapes + k] = encoding.steep_weights[place];
    }
}

void EncodingBlend::fill(const ShapeWeights& weights, int threads, const Execution& execution,
                         Encoding& result) const {
    parallel_for(vertex_count(), threads, execution, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            fill_vertex(v, weights.of(v), result);
    });
}

void EncodingBlend::fill_vertex(Index vertex, const double* weights, Encoding& result) const {
    const auto shapes = static_cast<std::size_t>(shape_count_);
    result.softening[vertex] = std::max(0.0, average(softening_.data() + vertex * shapes, weights, shape_count_));
    const Index begin = layout_.ring_offsets[vertex];
    const Index end = layout_.ring_offsets[vertex + 1];
    const Index steep = layout_.steep_offset[vertex];
    for (Index place = begin; place < end; ++place) {
        result.weights[place] = average(weights_.data() + place * shapes, weights, shape_count_);
        const double mean = average(angles_.data() + place * shapes, weights, shape_count_);
        if (steep >= 0) {
            const Index own = steep + place - begin;
            const double share = average(steep_weights_.data() + own * shapes, weights, shape_count_);
            result.steep_weights[own] = share;
            result.heights[place] = mean;
            result.cotangents[place] = share > kLeastWeight ? mean / share * kRestNormalLength : 0.0;
            continue;
        }
        const double cotangent = tangent(0.5 * kPi - std::clamp(mean, kLeastAngle, kPi - kLeastAngle));
        result.heights[place] = result.weights[place] * cotangent;
        result.cotangents[place] = cotangent * kRestNormalLength;
    }
}

std::size_t EncodingBlend::bytes() const {
    return layout_.bytes() + bytes_of(weights_) + bytes_of(angles_) + bytes_of(softening_) + bytes_of(steep_weights_);
}

}  // namespace meanvalue
