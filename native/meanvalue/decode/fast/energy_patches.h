// What DeformationEnergy knows of its rows at rest, in the order in which it goes through them.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/fast/energy_kernels.h"
#include "meanvalue/decode/fast/rest_cells.h"
#include "meanvalue/decode/fast/row_energy.h"
#include "meanvalue/decode/fast/stiff_spokes.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// Consecutive rows, and the vertices that they depend on, its points: numbered from 0 in each patch, and few enough
/// to stay in the cache while rows read their positions and add to their gradients. Batches of the patch have rows
/// of equal valence; single rows are those that the kernels don't take: steep rings, long ones.
struct EnergyPatch {
    std::int64_t first_point;
    std::int64_t first_batch;
    std::int64_t first_single;
};

struct SingleRow {
    Index row;
    Index centre;              ///< point of the patch
    std::int64_t first_spoke;  ///< in single_spokes and single_points
};

/// Memory is about 6 x 60 bytes for each row of six neighbours, 40 for the row, and 4 for each point.
struct EnergyPatches {
    std::vector<double> bending;           ///< a_i, |rows|
    double stretching = 0.0;               ///< (h/D)^2
    std::vector<StiffSpoke> stiff_spokes;  ///< by row, then by place

    std::vector<EnergyPatch> patches;  ///< and one more, where the last ends
    std::vector<RowBatch> batches;
    std::vector<BendingLanes> bending_lanes;  ///< for each batch as many as its valence
    std::vector<StretchingLanes> stretching_lanes;
    std::vector<EdgeLanes> edge_lanes;
    std::vector<VertexLanes> vertex_lanes;
    std::vector<SingleRow> singles;
    std::vector<Spoke> single_spokes;  ///< for each single row as many as its valence
    std::vector<Index> single_points;  ///< the same for its ring, points of the patch
    std::vector<Index> points;         ///< vertex numbers
    Index largest_patch = 0;           ///< in points
    Index longest_single = 0;          ///< valence

    std::size_t patch_count() const { return patches.size() - 1; }
    RingLanes rings() const {
        return {bending_lanes.data(), stretching_lanes.data(), edge_lanes.data(), vertex_lanes.data()};
    }
    std::size_t bytes() const;
};

/// The same for any number of threads of those who evaluate it. @param cells of the encoding; @param size D, in the
/// same units.
/// @param by_length from 0 to 1, the exponent of all weights of rows: at 1 a_i = h^2 / h_i^2, and rows that are
/// curved at rest count more in the second sum; at 0 all are alike.
/// @param in_batches false: all rows are single. @param hardness n, SoftConstraints::hardness(): soft anchors are as
/// much of an anchor as that. @param stiff of all rows at least, or nullptr: they are found. @throws Cancelled.
EnergyPatches build_energy_patches(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                   double size, double by_length, bool in_batches,
                                   const std::vector<double>& hardness, const StiffRings* stiff,
                                   const Execution& execution);

/// Puts the coefficients of an encoding of the same layout, and of other cells, into patches that were built for it;
/// stiff spokes stay. The same bits for any `threads`. @throws Cancelled.
void refill_energy_patches(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells, double size,
                           double by_length, const std::vector<double>& hardness, int threads,
                           const Execution& execution, EnergyPatches& patches);

}  // namespace meanvalue
