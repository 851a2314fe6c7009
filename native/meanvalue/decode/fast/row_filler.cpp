#include "meanvalue/decode/fast/row_filler.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/elementary.h"

namespace meanvalue {
namespace {

// How many times rigidity counts in a row: the least, where the shape is flat at rest; what is added for each unit of
// its mean curvature at rest, (1/r1 + 1/r2) D; and the most, reached by limbs of radius D/100. The thinner a limb,
// the less its strain costs beside its curvature, and it rolls about its axis: docs/decisions/0007-rigidity.md.
constexpr double kLeastRigidity = 0.8;
constexpr double kRigidityByCurvature = 0.016;
constexpr double kMostRigidity = 2.4;

// Edges shorter than this share of D count as so long: weights stay finite where vertices coincide.
constexpr double kShortestEdge = 1e-9;

/// How many times rigidity counts in a row. @param spokes `valence` of them.
double rigidity_of(const Spoke* spokes, Index valence, double size) {
    Vector3 area = Vector3::Zero();
    Vector3 sum = Vector3::Zero();
    double squares = 0.0;
    for (Index k = 0; k < valence; ++k) {
        area += spokes[k].rest.cross(spokes[k + 1 == valence ? 0 : k + 1].rest);
        sum += spokes[k].rest;
        squares += spokes[k].rest.squaredNorm();
    }
    // A sphere's vertex lies |e|^2 / 2r over a neighbour: their sum is that of the squares times (1/r1 + 1/r2) / 4.
    const double scale = area.norm() * squares;
    const double curvature = scale > 0.0 ? 4.0 * std::abs(area.dot(sum)) / scale : 0.0;
    return std::min(kLeastRigidity + kRigidityByCurvature * curvature * size, kMostRigidity);
}

}  // namespace

double share_of(double weight, double by_length) {
    return by_length == 1.0 ? weight : power(weight, by_length);
}

void RowFiller::fill(RowBatch& batch) {
    spokes_.resize(batch.valence);
    for (int lane = 0; lane < kRowLanes; ++lane) {
        const bool left_over = batch.row[lane] < 0;
        const std::size_t row = batch.row[left_over ? 0 : lane];
        const EncodedRing ring = encoding_.ring_of(unknowns_.rows[row]);
        measure(row, ring, spokes_.data());  // of a lane left over: the first row's again
        batch.softening.value[lane] = ring.softening;
        for (Index k = 0; k < batch.valence; ++k) {
            BendingLanes& bending = result_.bending_lanes[batch.first + k];
            bending.weight.value[lane] = ring.weights[k];
            bending.height.value[lane] = ring.heights[k];
            StretchingLanes& stretching = result_.stretching_lanes[batch.first + k];
            stretching.spoke.value[lane] = left_over ? 0.0 : spokes_[k].spoke;
            stretching.rim.value[lane] = left_over ? 0.0 : spokes_[k].rim;
            EdgeLanes& edge = result_.edge_lanes[batch.first + k];
            const Vector3& rest = spokes_[k].rest;
            edge.x.value[lane] = rest.x();
            edge.y.value[lane] = rest.y();
            edge.z.value[lane] = rest.z();
        }
    }
}

void RowFiller::fill(const SingleRow& single) {
    const EncodedRing ring = encoding_.ring_of(unknowns_.rows[single.row]);
    measure(single.row, ring, result_.single_spokes.data() + single.first_spoke);
}

void RowFiller::measure(std::size_t row, const EncodedRing& ring, Spoke* spokes) {
    const double length =
        measure_spokes(cells_.edges.data() + encoding_.ring_offsets[unknowns_.rows[row]], ring.valence, spokes);
    const double mean = std::max(length, kShortestEdge * size_);
    result_.bending[row] = 1.0 / (mean * mean);
    if (by_length_ == 0.0) return;
    const double rigidity = share_of(rigidity_of(spokes, ring.valence, size_), by_length_);
    for (Index k = 0; k < ring.valence; ++k) {
        spokes[k].spoke *= rigidity;
        spokes[k].rim *= rigidity;
    }
}

}  // namespace meanvalue
