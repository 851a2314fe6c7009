// Nearest places on the triangles of a mesh.
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
        Vector3 weights;      ///< of its corners, 0 to 1, with the sum 1
        Vector3 point;
    };

    /// What is looked for: triangles of other pieces than `part`, and where there is a `normal`, of unit length,
    /// those whose own has a cosine above `least_cosine` with it.
    struct Query {
        Vector3 point;
        Index part = kNoPart;
        const Vector3* normal = nullptr;
        double least_cosine = 0.0;
    };
    static constexpr Index kNoPart = -2;

    /// @param positions n x 3, @param part_of n: the piece of each vertex; both must outlive the tree. Triangles with
    /// a corner that is not finite are left out. @throws InvalidInput for corners that are no vertex, Cancelled.
    /// Cost: n log n.
    TriangleTree(const PositionsView& positions, Triangles triangles, const std::vector<Index>& part_of,
                 const Execution& execution);

    /// The nearest place, no farther than `reach`; of equally near ones that of the first triangle.
    Place nearest(const Query& query, double reach) const;

    const Triangles& triangles() const { return triangles_; }

  private:
    struct Box {
        Vector3 low, high;
        Index begin = 0, end = 0;  // of order_
        Index second = -1;         // the other half, the first one comes next; -1: a leaf
        Index part = -1;           // of all its triangles; -1: of several
    };

    Index add_box(Index begin, Index end, const Execution& execution);
    void search(Index box, const Query& query, double& least, Place& found) const;

    PositionsView positions_;
    Triangles triangles_;
    const std::vector<Index>& part_of_;
    std::vector<Index> order_;
    std::vector<Box> boxes_;
};

}  // namespace meanvalue
