// Which rings are too long to be solved for: one rule for all methods, to be asked before anything big is made.
#pragma once

#include <string>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What the normal matrix, its copies and factors take for each pair of free vertices in a row. Short rows share most
/// of their pairs with their neighbours; those of a long one are its own.
struct PairBytes {
    double in_long_rows;
    double in_short_rows;  ///< 0: as much as the mesh itself, which is nobody's fault
};
constexpr PairBytes kBlockPairs{360.0, 100.0};  ///< 3 x 3 blocks in a matrix, its copy and half of that in a factor
constexpr PairBytes kNumberPairs{120.0, 0.0};   ///< numbers, with factors for all stages of the fast method
constexpr PairBytes kNoPairs{0.0, 0.0};         ///< no matrix: only time, which goes with the square of the longest

/// Adds up rows, then tells whether they can be solved for.
class RingRoom {
  public:
    /// Free neighbours of one vertex. Each pair of them is coupled: the matrix has a dense block, and a factorisation
    /// of it takes the cube. Some seconds at this.
    static constexpr Index kMostNeighbours = 2048;

    explicit RingRoom(const PairBytes& bytes) : bytes_(bytes) {}

    /// The row of a vertex. @param vertex as the caller of the whole knows it. @param free_neighbours in its ring.
    void add(Index vertex, std::int64_t free_neighbours);

    /// @throws InvalidInput that names the vertex with the longest ring, its neighbours, and how to mend it.
    void require() const;

  private:
    PairBytes bytes_;
    Index longest_vertex_ = -1;
    std::int64_t longest_ = 0;
    Index long_row_count_ = 0;
    double long_bytes_ = 0.0;
    double short_bytes_ = 0.0;
};

/// Asks that of the one-rings of a region, without looking at them one by one: by the numbers of triangles.
/// @param is_fixed of the region's vertices. @throws as RingRoom::require(), by Region::vertices; Cancelled. Cost:
/// linear.
void require_room_for_rings(const Region& region, const std::vector<char>& is_fixed, const PairBytes& bytes,
                            const Execution& execution);

}  // namespace meanvalue
