// A separator of a graph, and how it is made smaller vertex by vertex.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/linalg/graph.h"

namespace meanvalue {

/// What a vertex belongs to: one of two sides without an edge between them, or what separates them.
enum Side : std::uint8_t { kLeft = 0, kRight = 1, kSeparator = 2 };

struct Separation {
    std::vector<Side> side;                   // of each vertex
    std::array<std::int64_t, 3> weight = {};  // of each side

    void assign(const Graph& graph, Index vertex, Side to) {
        weight[side[vertex]] -= graph.weights[vertex];
        weight[to] += graph.weights[vertex];
        side[vertex] = to;
    }
    /// Less is better: sides of at most `most` first, then the smaller separator, then equal sides.
    std::array<std::int64_t, 3> rank(std::int64_t most) const;
};

/// Moves vertices of the separator to a side, which pulls their neighbours on the other side into the separator, also
/// where it grows for a while, and keeps the best state seen (C. Ashcraft, J. W. H. Liu, Applications of the
/// Dulmage-Mendelsohn decomposition and network flow to graph bisection improvement, SIAM J. Matrix Anal. 19, 1998;
/// with the moves of C. Fiduccia, R. Mattheyses, A linear-time heuristic for improving network partitions, DAC 1982).
class SeparatorRefinement {
  public:
    /// @param most weight that a side should have. @throws Cancelled.
    void refine(const Graph& graph, Separation& separation, std::int64_t most, const Execution& execution);

  private:
    struct Move {
        Index vertex;
        Side to;
        Index pulled;  // how many
    };
    using Entry = std::pair<std::int64_t, Index>;  // gain, minus the vertex: of equal gains the first

    bool pass(const Graph& graph, Separation& separation, std::int64_t most, WorkMeter& work);
    void start(const Graph& graph, const Separation& separation, Index vertex, WorkMeter& work);
    void push(const Graph& graph, Index vertex, int to);
    bool top(const Graph& graph, const Separation& separation, int to, Entry& entry);
    bool choose(const Graph& graph, const Separation& separation, std::int64_t most, Index& vertex, Side& to);
    void move(const Graph& graph, Separation& separation, Index vertex, Side to, WorkMeter& work);
    void undo(const Graph& graph, Separation& separation);
    std::int64_t gain(const Graph& graph, Index vertex, int to) const {
        return graph.weights[vertex] - across_[to][vertex];
    }

    std::vector<Index> separator_;                     // what is in it, and may have been
    std::array<std::vector<std::int64_t>, 2> across_;  // for moving there: the weight that would be pulled
    std::array<std::vector<Entry>, 2> heap_;           // with entries that are out of date
    std::array<std::vector<std::int64_t>, 2> queued_;  // the gain of each vertex' entry that counts, its largest
    std::vector<Index> moved_in_;                      // the pass
    Index pass_ = 0;
    std::vector<Move> moves_;
    std::vector<Index> pulled_;
};

}  // namespace meanvalue
