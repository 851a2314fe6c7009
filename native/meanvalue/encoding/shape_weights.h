// How much each of several shapes counts.
#pragma once

#include <cstddef>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// Weights of shapes that sum to one, the same for all vertices or each vertex its own.
class ShapeWeights {
  public:
    /// @param values one for each of `shape_count` shapes, or `shape_count` times `vertex_count` of them, shape after
    /// shape; any numbers, also below 0 and above 1. They are divided by their sum.
    /// @throws InvalidInput where their number is another, one is not finite, or the sum is nothing beside them.
    ShapeWeights(const std::vector<double>& values, Index shape_count, Index vertex_count);

    Index shape_count() const { return shape_count_; }
    /// `shape_count` of them.
    const double* of(Index vertex) const {
        return values_.data() + (is_uniform_ ? 0 : static_cast<std::size_t>(vertex) * shape_count_);
    }
    bool is_uniform() const { return is_uniform_; }
    /// Averages over all vertices: what counts for the shape as a whole.
    const std::vector<double>& mean() const { return mean_; }

  private:
    Index shape_count_;
    bool is_uniform_;
    std::vector<double> values_;  // vertex after vertex
    std::vector<double> mean_;
};

/// The size of an in-between shape. @param values one for each shape, above 0; @param weights sum to one.
double geometric_mean(const std::vector<double>& values, const std::vector<double>& weights);

}  // namespace meanvalue
