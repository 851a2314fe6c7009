// Nearest places on the triangles of other pieces of a mesh.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A binary tree of boxes around triangles, of which each knows whether all that it holds is of one piece.
class TriangleTree {
  public:
    struct Place {
        Index triangle = -1;  ///< -1: none is near enough
        Vector3 point;
    };

    /// @param positions n x 3, @param part_of n: the piece of each vertex; both must outlive the tree. Triangles with
    /// a corner that is not finite are left out. @throws Cancelled. Cost: n log n.
    TriangleTree(const PositionsView& positions, Triangles triangles, const std::vector<Index>& part_of,
                 const Execution& execution);

    /// The place nearest to `point` on a triangle of another piece than `part`, no farther than `reach`; of several
    /// equally near ones always the same.
    Place nearest_of_others(const Vector3& point, Index part, double reach) const;

    const Triangles& triangles() const { return triangles_; }

  private:
    struct Box {
        Vector3 low, high;
        Index begin = 0, end = 0;  // of order_
        Index second = -1;         // the other half, the first one comes next; -1: a leaf
        Index part = -1;           // of all its triangles; -1: of several
    };

    Index add_box(Index begin, Index end, const Execution& execution);
    void search(Index box, const Vector3& point, Index part, double& least, Place& found) const;

    PositionsView positions_;
    Triangles triangles_;
    const std::vector<Index>& part_of_;
    std::vector<Index> order_;
    std::vector<Box> boxes_;
};

}  // namespace meanvalue
