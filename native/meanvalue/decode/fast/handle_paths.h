// The screws along which handles go from rest to their targets, and where they are on the way.
#pragma once

#include <vector>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// A screw motion: x -> centre + R(angle) (x - centre) + translation, R about `axis`. A fraction of it is a fraction
/// of both the angle and the translation, so that a handle on a bend goes along the arc and not through it.
struct ScrewMotion {
    Vector3 axis = Vector3::UnitX();
    double angle_rad = 0.0;  ///< 0 to pi
    Vector3 centre = Vector3::Zero();
    Vector3 translation = Vector3::Zero();

    Vector3 apply(const Vector3& point, double fraction) const;
};

/// The screw that the rigid motion x -> rotation x + translation is.
ScrewMotion screw_of(const Matrix3& rotation, const Vector3& translation);

/// The fixed vertices of a mesh, divided into pieces that move rigidly.
class HandlePaths {
  public:
    /// @param rest n x 3; @param is_fixed n flags. @param handles n, the handle of each fixed vertex, -1 for none;
    ///        or empty: fixed vertices joined by edges make a piece. @param size of the shape.
    HandlePaths(const Encoding& encoding, const PositionsView& rest, const std::vector<char>& is_fixed,
                const std::vector<Index>& handles, double size);

    /// For each of some fixed vertices the number of its piece.
    std::vector<Index> pieces_of(const std::vector<Index>& vertices) const { return picked(piece_of_, vertices); }

    struct Piece {
        std::vector<Index> vertices;
        Positions rest;
    };

    /// The path of the fixed vertices from rest to another place: rigid pieces along their screws, others straight.
    class Path {
      public:
        /// The largest angle that any piece rotates by.
        double largest_angle_rad() const { return largest_angle_rad_; }
        /// Puts every fixed vertex to where it is at `fraction` of the path; the others are not touched.
        void place(double fraction, Positions& positions) const;

      private:
        friend class HandlePaths;
        struct Way {
            const Piece* piece;
            Positions ends;
            ScrewMotion motion = {};
            bool is_rigid = false;
        };
        std::vector<Way> ways_;
        double largest_angle_rad_ = 0.0;
    };

    /// The path from rest to `placed_at`. @param is_free n flags of the vertices without a place of their own, or
    ///        empty: these go along with their piece if it is rigid, else to where `placed_at` has them.
    Path path_to(const PositionsView& placed_at, const std::vector<char>& is_free = {}) const;

  private:
    std::vector<Piece> pieces_;
    std::vector<Index> piece_of_;  // n: or -1
    double size_ = 0.0;
};

}  // namespace meanvalue
