// Nearest points.
#pragma once

#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A balanced k-d tree (Bentley 1975) over some rows of an array, split across the longest side of each box.
class PointTree {
  public:
    struct Nearest {
        Index row = -1;
        double squared_distance = 0.0;
    };

    /// @param positions n x 3 finite numbers, which must outlive the tree; @param rows of it, at least one.
    /// @throws Cancelled. Cost: n log n.
    PointTree(const PositionsView& positions, std::vector<Index> rows, const Execution& execution);

    /// The row nearest to `point`; of several equally near ones always the same.
    Nearest nearest(const Vector3& point) const;
    /// Whether any row is as near: the less that is, the sooner it is answered.
    bool has_within(const Vector3& point, double squared_distance) const;

  private:
    using Range = std::pair<std::size_t, std::size_t>;

    void split(Range range, const Execution& execution);
    void search(Range range, const Vector3& point, Nearest& best) const;
    static std::size_t middle_of(Range range) { return range.first + (range.second - range.first) / 2; }

    PositionsView positions_;
    std::vector<Index> rows_;          // each range with its middle between its halves
    std::vector<unsigned char> axis_;  // that the range with this middle is split across
};

}  // namespace meanvalue
