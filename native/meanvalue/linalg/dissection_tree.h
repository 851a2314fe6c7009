// The parts that a nested dissection took a graph into, to dissect one like it along them.
#pragma once

#include <vector>

#include "meanvalue/common/types.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/separator_refinement.h"

namespace meanvalue {

/// Each part is a range of places in the order of elimination: the parts that it was taken into, then what separates
/// them.
class DissectionTree {
  public:
    struct Part {
        Index begin;
        Index end;
    };

    DissectionTree() = default;
    /// @param parts in any order; each two are nested or apart. @param size of the whole order.
    DissectionTree(std::vector<Part> parts, Index size);

    bool empty() const { return parts_.empty(); }
    /// The same parts of an order in which place k has become `places[k]`, ascending. @param places size + 1.
    DissectionTree moved(const std::vector<Index>& places) const;

    /// How the smallest part in which nearly all vertices of `graph` lie was taken apart: what lies between its
    /// parts, or outside of it, and all vertices of one side next to the other, are the separator.
    /// @param places of each vertex, in the order of this tree. @return with an empty side where it was not.
    Separation separate(const Graph& graph, const std::vector<Index>& places) const;
    std::size_t bytes() const { return parts_.size() * sizeof(Part) + 2 * parts_.size() * sizeof(Index); }

  private:
    std::vector<Part> parts_;  // the whole first, each before those that it was taken into
    std::vector<Index> first_child_;
    std::vector<Index> next_sibling_;
};

}  // namespace meanvalue
