// Weighted averages of encodings: paper, section 4.3.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/shape_weights.h"

namespace meanvalue {

/// Encodings of several shapes of one mesh in a form that may be averaged: weights w_ij as they are, since their sums
/// stay one, and instead of the cotangents b_ij their angles, which are bounded (docs/algorithm.md, "Blending").
class EncodingBlend {
  public:
    /// @param encodings one or more of the same layout, as encode_alike() makes them.
    /// @throws InvalidInput that names the first vertex where the layouts differ; Cancelled.
    EncodingBlend(const std::vector<const Encoding*>& encodings, const Execution& execution);

    Index shape_count() const { return shape_count_; }
    Index vertex_count() const { return layout_.vertex_count(); }
    /// One to be filled: its rings and what is guarded.
    const Encoding& layout() const { return layout_; }
    /// Row i by the weights of vertex i. At one shape alone it is the encoding of that to rounding.
    /// @param result a copy of layout(), or filled before. The same bits for any `threads`. @throws Cancelled.
    void fill(const ShapeWeights& weights, int threads, const Execution& execution, Encoding& result) const;

    std::size_t bytes() const;

  private:
    void fill_vertex(Index vertex, const double* weights, Encoding& result) const;

    Index shape_count_;
    Encoding layout_;  // with the numbers of the first
    // For each half-edge that of one shape after another:
    std::vector<double> weights_;  // w_ij
    std::vector<double> angles_;   // of heights over weights; for steep rings the heights
    // For each vertex, and for each u_ij, in the same way:
    std::vector<double> softening_;
    std::vector<double> steep_weights_;
};

}  // namespace meanvalue
