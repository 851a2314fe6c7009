// A small set of vertices without which a graph falls into two parts.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/separator_refinement.h"

namespace meanvalue {

/// Finds separators on coarser and coarser graphs, then refines that of the coarsest from graph to graph (G. Karypis,
/// V. Kumar, A fast and high quality multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput. 20,
/// 1998). Keeps its memory for the next graph; one object serves one thread.
class SeparatorFinder {
  public:
    /// The same for the same graph, always. A side may be empty where the graph has no good separator.
    /// @param graph connected, of two vertices or more. @throws Cancelled.
    Separation find(const Graph& graph, const Execution& execution);
    /// One that is begun from `start`, where that leads to two sides; else as above.
    Separation find_near(const Graph& graph, Separation start, const Execution& execution);

  private:
    Separation grow(const Graph& graph, Index seed, const Execution& execution);
    std::vector<Separation> find_on_coarsest(const Graph& graph, const Execution& execution);
    void refine_and_select(const Graph& graph, std::vector<Separation>& separations, const Execution& execution);

    SeparatorRefinement refinement_;
    std::vector<Index> queue_;
};

}  // namespace meanvalue
