#include "bindings/polygons.h"

#include <array>

#include "meanvalue/common/errors.h"

namespace meanvalue::bindings {
namespace {

using Corners = std::array<Index, 3>;
using Flat = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Cuts ears off a polygon in a plane. From ear to ear it goes on round the polygon, and turns back at a corner that
/// is none, so that no corner becomes the tip of a fan.
class EarCutter {
  public:
    /// @param places of the corners, counter-clockwise.
    explicit EarCutter(const Flat& places) : places_(places), next_(places.rows()), before_(next_), turns_(next_) {
        const auto count = static_cast<Index>(places.rows());
        for (Index k = 0; k < count; ++k) {
            next_[k] = (k + 1) % count;
            before_[k] = (k + count - 1) % count;
        }
        for (Index k = 0; k < count; ++k)
            turns_[k] = turn(before_[k], k, next_[k]);
    }

    std::vector<Corners> cut() {
        std::vector<Corners> ears;
        Index at = 0;
        bool is_back = false;
        for (Index left = static_cast<Index>(next_.size()); left > 3; --left) {
            const Index tip = find_ear(at, left, is_back);
            const Index before = before_[tip];
            const Index after = next_[tip];
            ears.push_back({before, tip, after});
            next_[before] = after;
            before_[after] = before;
            if (first_ == tip) first_ = after;
            for (const Index beside : {before, after}) {
                if (turns_[beside] <= 0) turns_[beside] = turn(before_[beside], beside, next_[beside]);
            }
            at = is_back ? before_[before] : next_[after];
            if (turns_[at] <= 0) {
                at = is_back ? before_[at] : next_[at];
                is_back = !is_back;
            }
        }
        ears.push_back({first_, next_[first_], next_[next_[first_]]});
        return ears;
    }

  private:
    /// 1 to the left, -1 to the right, 0 straight on.
    Index turn(Index a, Index b, Index c) const {
        const Eigen::RowVector2d first = places_.row(b) - places_.row(a);
        const Eigen::RowVector2d second = places_.row(c) - places_.row(a);
        const double twice_the_area = first.x() * second.y() - first.y() * second.x();
        return twice_the_area > 0.0 ? 1 : twice_the_area < 0.0 ? -1 : 0;
    }

    bool is_ear(Index tip) const {
        if (turns_[tip] < 0) return false;
        for (Index k = next_[next_[tip]]; k != before_[tip]; k = next_[k]) {
            if (turns_[k] <= 0 && turn(before_[tip], tip, k) >= 0 && turn(tip, next_[tip], k) >= 0 &&
                turn(next_[tip], before_[tip], k) >= 0) {
                return false;
            }
        }
        return true;
    }

    /// Where there is none, as in a polygon that crosses itself: a corner that turns to no side but the left, or any.
    Index find_ear(Index from, Index left, bool is_back) const {
        Index tip = from;
        for (Index k = 0; k < left; ++k, tip = is_back ? before_[tip] : next_[tip]) {
            if (is_ear(tip)) return tip;
        }
        for (Index k = 0; k < left; ++k, tip = next_[tip]) {
            if (turns_[tip] >= 0) return tip;
        }
        return tip;
    }

    const Flat& places_;
    std::vector<Index> next_;
    std::vector<Index> before_;
    std::vector<Index> turns_;
    Index first_ = 0;
};

/// Seen along the mean normal.
Flat in_their_plane(const Positions& corners) {
    Vector3 normal = Vector3::Zero();
    for (Eigen::Index k = 0; k < corners.rows(); ++k) {
        const Vector3 here = corners.row(k).transpose();
        normal += here.cross(Vector3(corners.row((k + 1) % corners.rows()).transpose()));
    }
    const Vector3 across = normal.unitOrthogonal();
    Eigen::Matrix<double, 3, 2> axes;
    axes << across, normal.cross(across).normalized();
    return corners * axes;
}

std::vector<Corners> triangles_of(const Positions& corners) {
    if (corners.rows() == 3) return {{0, 1, 2}};
    if (corners.rows() > 4) return EarCutter(in_their_plane(corners)).cut();
    const Positions edges = corners.bottomRows(3).rowwise() - corners.row(0);
    const Vector3 diagonal = edges.row(1).transpose();
    const Vector3 first = diagonal.cross(Vector3(edges.row(0).transpose()));
    const bool turns_away = first.dot(diagonal.cross(Vector3(edges.row(2).transpose()))) > 0.0;
    if (turns_away) return {{0, 1, 3}, {1, 2, 3}};
    return {{0, 1, 2}, {0, 2, 3}};
}

void check(Eigen::Index vertex_count, const Polygons& polygons) {
    const std::vector<Index>& offsets = polygons.offsets;
    if (offsets.empty() || offsets.front() != 0 || offsets.back() != static_cast<Index>(polygons.corners.size())) {
        throw InvalidInput(message("faces has offsets from ", offsets.empty() ? 0 : offsets.front(), " to ",
                                   offsets.empty() ? 0 : offsets.back(), " for ", polygons.corners.size(),
                                   " corners; give one number for each face and one more, from 0 to their count"));
    }
    for (std::size_t face = 0; face + 1 < offsets.size(); ++face) {
        if (offsets[face + 1] - std::int64_t{offsets[face]} < 3) {
            throw InvalidInput(message("faces has ", offsets[face + 1] - std::int64_t{offsets[face]},
                                       " corners in face ", face, "; give 3 or more of each"));
        }
    }
    for (const Index corner : polygons.corners) {
        if (corner < 0 || corner >= vertex_count) {
            throw InvalidInput(message("faces names vertex ", corner, ", but there are ", vertex_count, " vertices"));
        }
    }
}

}  // namespace

Triangulation triangulate(const PositionsView& vertices, const Polygons& polygons) {
    check(vertices.rows(), polygons);
    const auto faces = static_cast<Index>(polygons.offsets.size()) - 1;
    Triangulation result;
    result.triangles.resize(static_cast<Eigen::Index>(polygons.corners.size()) - 2 * Eigen::Index{faces}, 3);
    for (Index face = 0; face < faces; ++face) {
        const Index* const corners = polygons.corners.data() + polygons.offsets[face];
        Positions places(polygons.offsets[face + 1] - polygons.offsets[face], 3);
        for (Eigen::Index k = 0; k < places.rows(); ++k)
            places.row(k) = vertices.row(corners[k]);
        for (const auto& [a, b, c] : triangles_of(places)) {
            result.triangles.row(static_cast<Eigen::Index>(result.polygons.size())) << corners[a], corners[b],
                corners[c];
            result.polygons.push_back(face);
        }
    }
    return result;
}

}  // namespace meanvalue::bindings
