// The coefficients of DeformationEnergy, laid out for its kernels: rows in batches of four, in blocks for the cache.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/fast/energy_kernels.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/encoding/rest_cells.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// A spoke of a row that resists by more than the smooth part of its prediction: see hessian_springs().
struct HessianSpring {
    Index row;
    Index place;  ///< in the ring
    double stiffness;
};

/// Consecutive rows, and the vertices that they depend on, its points: numbered from 0 in each block, and few enough
/// to stay in the cache while rows read their positions and add to their gradients.
struct EnergyBlock {
    std::int64_t first_point;
    std::int64_t first_batch;
};

/// Memory is about 6 x 60 bytes for each row of six neighbors, 40 for the row, and 4 for each point.
struct EnergyBlocks {
    std::vector<double> bending;                 ///< a_i, |rows|
    double stretching = 0.0;                     ///< (h/D)^2
    std::vector<HessianSpring> hessian_springs;  ///< by row, then by place

    std::vector<EnergyBlock> blocks;  ///< and one more, where the last ends
    std::vector<RowBatch> batches;
    std::vector<BendingLanes> bending_lanes;  ///< for each batch as many as its valence
    std::vector<StretchingLanes> stretching_lanes;
    std::vector<EdgeLanes> edge_lanes;
    std::vector<VertexLanes> vertex_lanes;
    std::vector<RowLanes> steep_lanes;  ///< for each steep batch as many as its valence
    std::vector<Index> points;          ///< vertex numbers
    Index largest_block = 0;            ///< in points
    Index longest_ring = 0;

    std::size_t block_count() const { return blocks.size() - 1; }
    RingLanes rings() const {
        return {bending_lanes.data(), stretching_lanes.data(), edge_lanes.data(), vertex_lanes.data(),
                steep_lanes.data()};
    }
};

/// @param cells of the encoding; @param size D, in the same units.
/// @param by_length from 0 to 1, the exponent of all weights of rows: at 1 a_i = h^2 / h_i^2, and rows that are
/// curved at rest count more in the second sum; at 0 all are alike.
/// @param hardness n, SoftConstraints::hardness(): soft anchors are as much of an anchor as that.
/// @param stiffness n factors of what each row counts in the second sum, or empty: 1.
/// The same for any number of threads. @throws Cancelled.
EnergyBlocks build_energy_blocks(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                 double size, double by_length, const std::vector<double>& hardness,
                                 const std::vector<double>& stiffness, int threads, const Execution& execution);

/// Puts other cells in place of those that `blocks` were built for, and the coefficients of their encoding. What
/// rows and edges count stays. @param encoding, cells of the same layout. The same bits for any `threads`. @throws
/// Cancelled.
void refill_energy_blocks(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, int threads,
                          const Execution& execution, EnergyBlocks& blocks);

}  // namespace meanvalue
