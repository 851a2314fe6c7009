#include <algorithm>
#include <cmath>

#include "meanvalue/common/parallel.h"
#include "meanvalue/follow/sheets.h"

namespace meanvalue {
namespace {

// Shares of the carrier's size. A sheet may sink to half its height, or to this if that is less.
constexpr double kLeastHeight = 0.007;
// Up to so far they count whole, and not at all from twice as far on: skirts got spikes without this fade.
constexpr double kNearHeight = 0.015;
constexpr double kNearCover = 0.05;
// What covers a vertex lies before it, and in about the same plane: cosines.
constexpr double kLeastCosine = 0.3;
// A lift raises what it lifts over, so there is a second one; then both are smoothed so many times.
constexpr int kPasses = 2;
constexpr int kSmoothings = 2;

/// 1 up to `near`, and down to 0 at twice that.
double fade(double distance, double near) {
    return std::clamp(2.0 - distance / near, 0.0, 1.0);
}

/// Whether the place of a sheet covers a vertex of the carrier. Not where another part of the carrier is nearer, or
/// on the sheet's other side: a raised hand is not below the skirt.
bool covers(const TriangleTree& sheets, const TriangleTree::Place& place, const PositionsView& own,
            const TriangleTree& carrier, const Vector3& point, const Vector3& normal) {
    const Vector3 way = place.point - point;
    const double distance = way.norm();
    if (!(way.dot(normal) > kLeastCosine * distance)) return false;
    const auto corners = sheets.triangles().row(place.triangle);
    const Vector3 first = own.row(corners[0]);
    const Vector3 across =
        (own.row(corners[1]).transpose() - first).cross(own.row(corners[2]).transpose() - first).normalized();
    if (!(std::abs(across.dot(normal)) > kLeastCosine)) return false;
    const TriangleTree::Place foot = carrier.nearest({place.point}, distance);
    return foot.triangle >= 0 && (foot.point - point).norm() <= distance &&
           (foot.point - place.point).dot(across) * -way.dot(across) > 0.0;
}

}  // namespace

Lift::Lift(const PositionsView& rest, const CarrierSurface& carrier, double size, const PositionsView& own,
           const Triangles& own_faces, const std::vector<SheetHold>& holds, int threads, const Execution& execution) {
    const std::vector<Index> one_part(own.rows(), 0);
    const TriangleTree own_tree(own, own_faces, one_part, execution);
    const auto own_count = static_cast<Index>(own.rows());
    std::vector<Height> found(own.rows() + rest.rows());
    parallel_for(static_cast<Index>(found.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            Height& height = found[k];
            if (k < own_count) {
                height.above = {{k, k, k}, Vector3::UnitX()};
                height.below = holds[k].place;
                height.weight = fade(holds[k].offset.norm(), kNearHeight * size);
            } else {
                const Index v = k - own_count;
                if (carrier.fans().of(v).empty()) continue;
                const Vector3 point = rest.row(v);
                const TriangleTree::Place place = own_tree.nearest({point}, 2.0 * kNearCover * size);
                if (place.triangle < 0) continue;
                if (!covers(own_tree, place, own, carrier.tree(), point, carrier.normals()[v])) continue;
                height.above = place_on(own_tree, place);
                height.below = {{v, v, v}, Vector3::UnitX()};
                height.weight = fade((place.point - point).norm(), kNearCover * size);
            }
            height.sheet = holds[height.above.corners[0]].sheet;
            height.least = (height.above.of(own.data()) - height.below.of(rest.data()))
                               .dot(height.below.normal(carrier.normals()));
            if (height.least > 0.0) height.least = std::min(0.5 * height.least, kLeastHeight * size);
        }
    });
    std::copy_if(found.begin(), found.end(), std::back_inserter(heights_),
                 [](const Height& height) { return height.weight > 0.0; });
    uses_ = grouped<Use>(own.rows(), [&](const auto& visit) {
        for (std::size_t k = 0; k < heights_.size(); ++k) {
            for (int c = 0; c < 3; ++c) {
                const double weight = heights_[k].weight * heights_[k].above.weights[c];
                if (weight > 0.0) visit(heights_[k].above.corners[c], Use{static_cast<Index>(k), weight});
            }
        }
    });
}

void Lift::apply(const double* positions, const std::vector<Vector3>& normals, const std::vector<double>& growth,
                 const Encoding& encoding, int threads, const Execution& execution, Positions& own) const {
    struct Floor {
        Vector3 normal;
        double along;  // the normal
        double need;
    };
    const auto count = static_cast<Index>(own.rows());
    std::vector<Floor> floors(heights_.size());
    std::vector<Vector3> lifts(own.rows(), Vector3::Zero()), smooth(own.rows());
    for (int pass = 0; pass < kPasses; ++pass) {
        parallel_for(static_cast<Index>(heights_.size()), threads, execution, [&](Index begin, Index end) {
            for (Index k = begin; k < end; ++k) {
                const Height& height = heights_[k];
                auto& [normal, along, need] = floors[k];
                if (pass == 0) {
                    normal = height.below.normal(normals);
                    along = height.below.of(positions).dot(normal) + growth[height.sheet] * height.least;
                }
                need = std::max(0.0, along - height.above.of(own.data()).dot(normal));
            }
        });
        // Larger needs count more: much of what a coarse sheet covers needs nothing.
        parallel_for(count, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                Vector3 sum = Vector3::Zero();
                double weights = 0.0;
                double needs = 0.0;
                for (const auto& [height, weight] : uses_.of(v)) {
                    const Floor& floor = floors[height];
                    sum += weight * floor.need * floor.need * floor.normal;
                    weights += weight;
                    needs += weight * floor.need;
                }
                if (!(needs > 0.0)) continue;
                sum *= std::min(1.0, weights) / needs;
                lifts[v] += sum;
                own.row(v) += sum;
            }
        });
    }
    for (int smoothing = 0; smoothing < kSmoothings; ++smoothing) {
        parallel_for(count, threads, execution, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                Vector3 sum = Vector3::Zero();
                const EncodedRing ring = encoding.ring_of(v);
                for (Index k = 0; k < ring.valence; ++k)
                    sum += lifts[ring.ring[k]];
                smooth[v] = lifts[v];
                const double length = sum.norm();
                const double excess = length > 0.0 ? length / ring.valence - lifts[v].norm() : 0.0;
                if (!(excess > 0.0)) continue;
                sum *= 0.5 * excess / length;
                smooth[v] += sum;
                own.row(v) += sum;
            }
        });
        lifts.swap(smooth);
    }
}

}  // namespace meanvalue
