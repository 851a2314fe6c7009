// The order of elimination of a small graph.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// A small graph of which some vertices are eliminated and the others stay; rows of bits.
/// Quick for some hundreds of vertices: the time grows with the cube of their number, divided by 64.
class MinimumDegree {
  public:
    /// Begins a graph without edges. @param inner vertices [0, inner) are to be eliminated.
    /// @param size all; those behind the inner ones stay, and count for the degrees.
    void reset(Index inner, Index size);
    /// @param inner of the inner vertices. @param vertex any other.
    void connect(Index inner, Index vertex);

    /// The inner vertices in an order in which each is one with the fewest neighbours when its turn comes; of several
    /// the first. Exact degrees, not bounds of them (A. George, J. W. H. Liu, The evolution of the minimum degree
    /// ordering algorithm, SIAM Review 31, 1989). The graph is used up.
    const std::vector<Index>& order();

  private:
    std::uint64_t* row(Index vertex) { return bits_.data() + static_cast<std::size_t>(vertex) * words_; }
    void eliminate(Index vertex);

    Index inner_ = 0;
    Index words_ = 0;
    std::vector<std::uint64_t> bits_;
    std::vector<std::uint64_t> clique_;
    std::vector<Index> degree_;
    std::vector<Index> order_;
};

}  // namespace meanvalue
