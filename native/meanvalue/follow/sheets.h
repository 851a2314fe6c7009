// Clothes: loose parts that bend with the surface that they lie on.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/grouped.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/follow/carrier_surface.h"
#include "meanvalue/follow/lift.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/triangle_tree.h"

namespace meanvalue {

/// Each vertex of a sheet is drawn to where the patch of the carrier below it takes it, the more the nearer it is;
/// and the sheet keeps its own shape besides, the details of which are rotated as those patches are. Then it is
/// lifted out of the carrier where it sank. One linear solve with a matrix that is factored at bind; a function of
/// the carrier's pose alone, and a similarity of it takes the sheets along exactly. docs/algorithm.md, "Clothes".
class Sheets {
  public:
    /// @param rest n x 3. @param carrier with its tree, of the same numbers. @param faces of the mesh.
    /// @param sheet_of n: the number of the sheet of each vertex, from 0, or -1. @throws Cancelled.
    Sheets(const PositionsView& rest, CarrierSurface carrier, const TriangleTree& carrier_tree,
           const TrianglesView& faces, const std::vector<Index>& sheet_of, InstructionSet instructions, int threads,
           const Execution& execution);

    /// Puts the rows of the sheets to where they go along to.
    /// @param positions 3 n numbers, vertex by vertex; the carrier's are read.
    /// The same bits for any `threads`. @throws Cancelled.
    void carry(double* positions, int threads, const Execution& execution) const;

    const std::vector<Index>& vertices() const { return vertices_; }  ///< of the mesh, ascending

  private:
    struct CarrierEdge {
        Index a, b;
        double length;
    };

    void hold(const PositionsView& rest, const TriangleTree& carrier_tree, int threads, const Execution& execution);
    void weigh(const Encoding& encoding, const RestCells& cells);
    void link(const Encoding& encoding, const RestCells& cells, const Execution& execution);
    void factorise(int threads, const Execution& execution);
    void list_carrier(const double* rest);
    std::vector<double> growths(const double* positions, int threads, const Execution& execution) const;
    Positions pulls(const Positions& targets, const std::vector<Matrix3>& rotations, int threads,
                    const Execution& execution) const;

    CarrierSurface carrier_;
    std::vector<Index> vertices_;  // k
    Positions own_;                // k x 3, at rest
    std::vector<SheetHold> holds_;
    std::vector<SurfacePatch> patches_;
    Index sheet_count_ = 0;
    std::vector<std::vector<CarrierEdge>> carrier_edges_;  // of each sheet: those below it, by which it grows
    std::vector<Index> carrier_vertices_;                  // whose normals are read
    std::vector<double> bending_;                          // k: what each row counts, 0 where there is none
    std::vector<double> stretching_;                       // k
    std::vector<double> springs_;                          // k
    Grouped<SheetEdge> rows_;                              // the rings with the weights W
    Grouped<SheetEdge> columns_;                           // the same by the other end
    Grouped<SheetEdge> edges_;                             // with what their lengths count, once for each cell
    SupernodalFactor factor_;
    bool is_factored_ = false;
    Lift lift_;
};

}  // namespace meanvalue
