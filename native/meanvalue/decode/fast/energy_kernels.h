// The rows of DeformationEnergy four at a time, double precision: one lane of a vector instruction is one row.
#pragma once

#include <cstdint>
#include <vector>

#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

constexpr int kRowLanes = 4;

/// One number of each row of a batch.
struct alignas(kRowLanes * sizeof(double)) RowLanes {
    double value[kRowLanes];
};

/// One vertex' x, y, z and a zero: a row that one instruction loads.
struct alignas(kRowLanes * sizeof(double)) PaddedPoint {
    double value[kRowLanes];
};

/// Four rows whose rings are equally long. Vertices are numbered within the block that the batch belongs to. Where
/// there are fewer rows, the lanes left over repeat the first, with zeros for what multiplies their energy.
struct RowBatch {
    RowLanes softening;        ///< see SoftNormal
    RowLanes bending;          ///< a_i
    Index centre[kRowLanes];   ///< i
    Index row[kRowLanes];      ///< which row of the energy; -1: a lane left over
    Index valence;             ///< of all four
    std::int64_t first;        ///< where its rings begin in each array of RingLanes but the last
    std::int64_t first_steep;  ///< where they begin in that; -1: no ring is steep
};

/// Coefficients of one place in the rings of a batch, by what reads them.
struct BendingLanes {
    RowLanes weight;  ///< w_ik
    RowLanes height;  ///< see Encoding::heights
};
struct StretchingLanes {
    RowLanes spoke;  ///< c_ik
    RowLanes rim;    ///< c_kl, l the next in the ring
};
struct EdgeLanes {
    RowLanes x, y, z;  ///< p_i - p_k at rest, in the frame of the cell
};
struct VertexLanes {
    Index vertex[kRowLanes];  ///< k
};
struct RingLanes {
    const BendingLanes* bending;
    const StretchingLanes* stretching;
    const EdgeLanes* edges;
    const VertexLanes* vertices;
    const RowLanes* steep;  ///< of steep rings: u_ik - w_ik, scaled (Encoding::steep_weights)
};

/// What a kernel keeps of the rings of a batch.
class KernelScratch {
  public:
    /// For rings of at most `longest` vertices.
    void resize(Index longest) { values_.resize(kArrays * 3 * static_cast<std::size_t>(longest)); }
    /// Array `number` of four, `valence` x 3 of them.
    RowLanes* array(int number, Index valence) {
        return values_.data() + static_cast<std::size_t>(number) * 3 * static_cast<std::size_t>(valence);
    }

  private:
    static constexpr std::size_t kArrays = 4;
    std::vector<RowLanes> values_;
};

/// E of `count` batches. Adds its derivative by each vertex to `gradient`, batch after batch in their order.
/// @param positions, gradient of the vertices of the block.
/// @param stretching what the second sum is multiplied with; 0: it is not made.
using EnergyKernel = double (*)(const RowBatch* batches, Index count, const RingLanes& rings,
                                const PaddedPoint* positions, double stretching, KernelScratch& scratch,
                                PaddedPoint* gradient);

EnergyKernel energy_kernel(InstructionSet instructions);

}  // namespace meanvalue
