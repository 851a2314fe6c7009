// Clothes: loose parts that bend with the surface that they lie on.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/linalg/supernodal_factor.h"

namespace meanvalue {

/// A vertex of a sheet: where it hangs on its carrier.
struct SheetHold {
    SurfacePlace place;  ///< nearest to it
    Vector3 offset;      ///< from there, at rest
    Index sheet = 0;
};

/// Clothes that a pose would put below their carrier are lifted out again, one way only. Heights that sheets keep
/// over their carrier, at least: each of their vertices over its place, and the places that cover a vertex of the
/// carrier over that.
class Lift {
  public:
    struct Height {
        SurfacePlace above;  ///< on a sheet
        SurfacePlace below;  ///< on the carrier
        Index sheet = 0;
        double least = 0.0;
        double weight = 0.0;
    };

    Lift() = default;
    /// @param rest n x 3 of the whole mesh; @param size of the carrier; @param own the sheets' vertices, their faces
    /// in their own numbers. @throws Cancelled.
    Lift(const PositionsView& rest, const CarrierSurface& carrier, double size, const PositionsView& own,
         const Triangles& own_faces, const std::vector<SheetHold>& holds, int threads, const Execution& execution);

    /// @param positions n x 3, of which the carrier's are read. @param growth of each sheet. @param encoding with the
    /// rings of `own`, k x 3, which is moved. The same bits for any `threads`. @throws Cancelled.
    void apply(const double* positions, const std::vector<Vector3>& normals, const std::vector<double>& growth,
               const Encoding& encoding, int threads, const Execution& execution, Positions& own) const;

    const std::vector<Height>& heights() const { return heights_; }

  private:
    struct Use {  // a height that a vertex is above
        Index height;
        double weight;
    };

    std::vector<Height> heights_;
    Grouped<Use> uses_;
};

/// Each vertex of a sheet is drawn to where the patch of the carrier below it takes it, the more the nearer it is;
/// and the sheet keeps its own shape besides, turned as those patches are: one solve with the initial Hessian of
/// poses, which is factored at bind. Then it is lifted out of the carrier where it sank. A function of the carrier's
/// pose alone, and a similarity of it takes the sheets along exactly. docs/algorithm.md, "Clothes".
class Sheets {
  public:
    /// @param rest n x 3. @param size of the carrier. @param faces of the mesh.
    /// @param sheet_of n: the number of the sheet of each vertex, from 0, or -1. @throws Cancelled.
    Sheets(const PositionsView& rest, const CarrierSurface& carrier, double size, const TrianglesView& faces,
           const std::vector<Index>& sheet_of, InstructionSet instructions, int threads, const Execution& execution);
    Sheets(const Sheets&) = delete;

    /// Puts the rows of the sheets to where they go along to.
    /// @param positions 3 n numbers, vertex by vertex; the carrier's are read.
    /// The same bits for any `threads`. @throws Cancelled.
    void carry(double* positions, int threads, const Execution& execution) const;

  private:
    struct Link {
        Index other;
        double weight;
    };

    void hold(const PositionsView& rest, const CarrierSurface& carrier, int threads, const Execution& execution);
    void bind(double size, InstructionSet instructions, int threads, const Execution& execution);
    Positions pulls(const Positions& targets, const std::vector<Matrix3>& rotations, int threads,
                    const Execution& execution) const;

    std::vector<Index> vertices_;  // k: of the mesh, ascending
    Positions own_;                // k x 3, at rest
    std::vector<SheetHold> holds_;
    std::vector<SurfacePatch> patches_;
    std::vector<RestEdges> edges_below_;  // of each sheet: the carrier's, by which it grows
    Grouped<Index> carrier_fans_;         // n
    std::vector<Index> read_;             // vertices of the carrier whose normals count
    Encoding encoding_;
    std::vector<double> bending_;  // k: what the row of each vertex counts
    Grouped<Link> columns_;        // k: the rows that predict others by a vertex, and its weight there
    SparseMatrix edges_;           // k x k: of the factored matrix what lengths count
    SupernodalFactor factor_;
    bool is_factored_ = false;  // or sheets go to where their springs draw them
    Lift lift_;
};

}  // namespace meanvalue
