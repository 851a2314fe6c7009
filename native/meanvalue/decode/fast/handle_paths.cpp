#include "meanvalue/decode/fast/handle_paths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/linalg/procrustes.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

// A piece is rigid where its vertices end within this share of the size from where a rigid motion takes them.
constexpr double kRigid = 1e-3;
// Three points span a plane; fewer leave the rotation open.
constexpr std::size_t kFewestForRotation = 3;

/// The rotation and translation nearest to a similarity fit.
Similarity rigid_fit(const Positions& from, const Positions& to) {
    std::vector<Index> all(from.rows());
    std::iota(all.begin(), all.end(), 0);
    Similarity fit = fit_similarity(from, to, all);
    fit.scale = 1.0;
    fit.translation = mean_row(to) - fit.rotation * mean_row(from);
    return fit;
}

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
    for (Index v = 0; v < count; ++v) {
        if (is_fixed[v]) vertices_.push_back(v);
    }
    std::stable_sort(vertices_.begin(), vertices_.end(),
                     [&](Index a, Index b) { return pieces.root(a) < pieces.root(b); });
    rest_ = rest(vertices_, Eigen::all);
    for (std::size_t k = 1; k <= vertices_.size(); ++k) {
        const bool is_last = k == vertices_.size() || pieces.root(vertices_[k]) != pieces.root(vertices_[k - 1]);
        if (is_last) starts_.push_back(k);
    }
}

std::vector<Index> HandlePaths::pieces_of(const std::vector<Index>& vertices) const {
    std::map<Index, Index> piece_of;
    for (std::size_t piece = 0; piece + 1 < starts_.size(); ++piece) {
        for (std::size_t k = starts_[piece]; k < starts_[piece + 1]; ++k)
            piece_of[vertices_[k]] = static_cast<Index>(piece);
    }
    std::vector<Index> pieces;
    pieces.reserve(vertices.size());
    for (const Index v : vertices)
        pieces.push_back(piece_of.at(v));
    return pieces;
}

HandlePaths::Path HandlePaths::path_to(const PositionsView& placed_at, const std::vector<char>& is_free) const {
    Path path;
    path.pieces_ = this;
    path.ends_ = placed_at(vertices_, Eigen::all);
    for (std::size_t piece = 0; piece + 1 < starts_.size(); ++piece) {
        std::vector<std::size_t> placed;
        std::vector<std::size_t> free;
        for (std::size_t k = starts_[piece]; k < starts_[piece + 1]; ++k)
            (is_free.empty() || !is_free[vertices_[k]] ? placed : free).push_back(k);
        ScrewMotion motion;
        bool rigid = false;
        if (placed.size() >= kFewestForRotation) {
            const Positions from = rest_(placed, Eigen::all);
            const Positions to = path.ends_(placed, Eigen::all);
            const Similarity fit = rigid_fit(from, to);
            // About its middle: where the mesh is far from the origin, the axis would be lost in rounding.
            const Vector3 middle = mean_row(from);
            motion = screw_of(fit.rotation, fit.apply(middle) - middle);
            motion.centre += middle;
            const Positions missed = to - ((from * fit.rotation.transpose()).rowwise() + fit.translation.transpose());
            rigid = missed.rowwise().norm().maxCoeff() < kRigid * size_;
            for (const std::size_t k : free) {
                if (rigid) path.ends_.row(k) = fit.apply(rest_.row(k)).transpose();
            }
        }
        path.is_rigid_.push_back(rigid);
        path.motions_.push_back(motion);
        if (rigid) path.largest_angle_rad_ = std::max(path.largest_angle_rad_, motion.angle_rad);
    }
    return path;
}

void HandlePaths::Path::place(double fraction, Positions& positions) const {
    for (std::size_t piece = 0; piece < motions_.size(); ++piece) {
        for (std::size_t k = pieces_->starts_[piece]; k < pieces_->starts_[piece + 1]; ++k) {
            const Vector3 begin = pieces_->rest_.row(k);
            const Vector3 end = ends_.row(k);
            Vector3 point = end;  // exact at the end
            if (fraction < 1.0)
                point = is_rigid_[piece] ? motions_[piece].apply(begin, fraction)
                                         : Vector3(begin + fraction * (end - begin));
            positions.row(pieces_->vertices_[k]) = point;
        }
    }
}

}  // namespace meanvalue
