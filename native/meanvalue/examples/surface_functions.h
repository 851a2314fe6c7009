// Smooth functions over a surface that sum to one: what weights that vary slowly over a mesh are made of.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// Bells of the distance along edges from vertices far from each other, divided by their sum.
class SurfaceFunctions {
  public:
    struct Value {
        Index function;
        double value;
    };

    /// @param layout the rings, n. @param positions n x 3. @throws Cancelled. Cost: that of sorting, for each
    /// function.
    SurfaceFunctions(const Encoding& layout, const PositionsView& positions, const Execution& execution);

    Index count() const { return count_; }
    /// Those that are not 0 at a vertex.
    const Value* begin(Index vertex) const { return values_.data() + start_[vertex]; }
    const Value* end(Index vertex) const { return values_.data() + start_[vertex + 1]; }

  private:
    Index count_ = 0;
    std::vector<std::size_t> start_;  // n + 1
    std::vector<Value> values_;
};

}  // namespace meanvalue
