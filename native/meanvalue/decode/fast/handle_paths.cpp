#include "meanvalue/decode/fast/handle_paths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

// A piece is rigid where its vertices end within this share of the size from where a rigid motion takes them.
constexpr double kRigid = 1e-3;
// Three points span a plane; fewer leave the rotation open.
constexpr std::size_t kFewestForRotation = 3;

}  // namespace

Vector3 ScrewMotion::apply(const Vector3& point, double fraction) const {
    const auto [sine, cosine] = sine_cosine(fraction * angle_rad);
    const Vector3 arm = point - centre;
    const Vector3 rotated = cosine * arm + sine * axis.cross(arm) + (1.0 - cosine) * axis.dot(arm) * axis;
    return centre + rotated + fraction * translation;
}

ScrewMotion screw_of(const Matrix3& rotation, const Vector3& translation) {
    const Eigen::Quaterniond quaternion(rotation);
    const double sine_of_half = quaternion.vec().norm();
    const double cosine_of_half = std::abs(quaternion.w());
    const double angle_rad = 2.0 * arc_tangent(sine_of_half, cosine_of_half);
    ScrewMotion screw;
    if (angle_rad < kCoincident) {  // a translation: the axis would be lost in rounding
        screw.translation = translation;
        return screw;
    }
    screw.axis = (quaternion.w() < 0.0 ? -1.0 : 1.0) / sine_of_half * quaternion.vec();
    screw.angle_rad = angle_rad;
    screw.translation = translation.dot(screw.axis) * screw.axis;
    const Vector3 across = translation - screw.translation;
    screw.centre = 0.5 * (across + cosine_of_half / sine_of_half * screw.axis.cross(across));
    return screw;
}

HandlePaths::HandlePaths(const Encoding& encoding, const PositionsView& rest, const std::vector<char>& is_fixed,
                         const std::vector<Index>& handles, double size)
    : size_(size) {
    const auto count = static_cast<Index>(is_fixed.size());
    DisjointSets pieces(count);
    std::map<Index, Index> first_of_handle;
    for (Index v = 0; v < count; ++v) {
        if (!is_fixed[v]) continue;
        if (!handles.empty() && handles[v] >= 0)
            pieces.join(first_of_handle.try_emplace(handles[v], v).first->second, v);
        for (Index k = encoding.ring_offsets[v]; k < encoding.ring_offsets[v + 1]; ++k) {
            const Index other = encoding.ring[k];
            if (is_fixed[other] && (handles.empty() || handles[other] == handles[v])) pieces.join(v, other);
        }
    }
    piece_of_.assign(count, -1);
    for (Index v = 0; v < count; ++v) {
        if (!is_fixed[v]) continue;
        const Index root = pieces.root(v);  // the lowest, which comes first
        if (root == v) pieces_.emplace_back();
        piece_of_[v] = root == v ? static_cast<Index>(pieces_.size()) - 1 : piece_of_[root];
        pieces_[piece_of_[v]].vertices.push_back(v);
    }
    for (Piece& piece : pieces_)
        piece.rest = rest(piece.vertices, Eigen::all);
}

HandlePaths::Path HandlePaths::path_to(const PositionsView& placed_at, const std::vector<char>& is_free) const {
    Path path;
    for (const Piece& piece : pieces_) {
        Path::Way way{&piece, placed_at(piece.vertices, Eigen::all)};
        std::vector<Index> placed, free;  // rows of the piece
        for (std::size_t k = 0; k < piece.vertices.size(); ++k)
            (is_free.empty() || !is_free[piece.vertices[k]] ? placed : free).push_back(static_cast<Index>(k));
        if (placed.size() >= kFewestForRotation) {
            const Correlation sums = correlate(piece.rest, way.ends, placed.data(), placed.size());
            const Matrix3 rotation = fit_rotation(sums.covariance);
            const auto carried = [&](Index row) -> Vector3 {
                return sums.to_centre + rotation * (Vector3(piece.rest.row(row)) - sums.from_centre);
            };
            // About its middle: where the mesh is far from the origin, the axis would be lost in rounding.
            way.motion = screw_of(rotation, sums.to_centre - sums.from_centre);
            way.motion.centre += sums.from_centre;
            way.is_rigid = std::all_of(placed.begin(), placed.end(), [&](Index row) {
                return (carried(row) - Vector3(way.ends.row(row))).norm() < kRigid * size_;
            });
            for (const Index row : free) {
                if (way.is_rigid) way.ends.row(row) = carried(row);
            }
        }
        if (way.is_rigid) path.largest_angle_rad_ = std::max(path.largest_angle_rad_, way.motion.angle_rad);
        path.ways_.push_back(std::move(way));
    }
    return path;
}

void HandlePaths::Path::place(double fraction, Positions& positions) const {
    for (const Way& way : ways_) {
        for (std::size_t k = 0; k < way.piece->vertices.size(); ++k) {
            const Vector3 begin = way.piece->rest.row(k);
            const Vector3 end = way.ends.row(k);
            Vector3 point = end;  // exact at the end
            if (fraction < 1.0)
                point = way.is_rigid ? way.motion.apply(begin, fraction) : Vector3(begin + fraction * (end - begin));
            positions.row(way.piece->vertices[k]) = point;
        }
    }
}

}  // namespace meanvalue
