// Which rings are too long to be solved for: one rule for all methods, to be asked before anything big is made.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What the normal matrix, its copies and factors take for each pair of free vertices in a row. Short rows share most
/// of their pairs with their neighbors; those of a long one are its own.
struct PairBytes {
    double in_long_rows;
    double in_short_rows;  ///< 0: about as much as the mesh itself
};
constexpr PairBytes kBlockPairs{360.0, 100.0};  ///< 3 x 3 blocks in a matrix, its copy and half of that in a factor
constexpr PairBytes kNumberPairs{120.0, 0.0};   ///< numbers, with factors for all stages of the fast method
constexpr PairBytes kNoPairs{0.0, 0.0};         ///< no matrix

/// Adds up rows, then tells whether they can be solved for.
class RingRoom {
  public:
    /// Free neighbors of one vertex. Each pair of them is coupled: the matrix has a dense block, and a factorization
    /// of it takes the cube. Some seconds at this.
    static constexpr Index kMostNeighbours = 2048;

    explicit RingRoom(const PairBytes& bytes) : pair_bytes_(bytes) {}

    /// The row of a vertex. @param vertex as the caller of the whole knows it. @param free_neighbours in its ring.
    void add(Index vertex, std::int64_t free_neighbours);

    /// @throws InvalidInput that names the vertex with the longest ring, its neighbors, and how to mend it.
    void require() const;

  private:
    PairBytes pair_bytes_;
    Index longest_vertex_ = -1;
    std::int64_t longest_ = 0;
    double bytes_ = 0.0;
};

/// Asks that of the one-rings of a region, by the numbers of triangles: where several fans meet at a vertex, as if
/// they were one. @param is_fixed of the region's vertices. @throws as RingRoom::require(), by Region::vertices;
/// Cancelled. Cost: linear.
void require_room_for_rings(const Region& region, const std::vector<char>& is_fixed, const PairBytes& bytes,
                            const Execution& execution);

}  // namespace meanvalue
