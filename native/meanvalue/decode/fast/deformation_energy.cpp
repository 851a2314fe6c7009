#include "meanvalue/decode/fast/deformation_energy.h"

#include <numeric>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/energy_blocks.h"

namespace meanvalue {

DeformationEnergy::DeformationEnergy(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                     double size, double by_length, const Execution& execution,
                                     InstructionSet instructions, SoftConstraints soft_constraints, int threads,
                                     const std::vector<double>& stiffness)
    : encoding_(encoding),
      unknowns_(unknowns),
      soft_constraints_(std::move(soft_constraints)),
      kernel_(energy_kernel(instructions)),
      rows_(build_energy_blocks(encoding, unknowns, cells, size, by_length,
                                soft_constraints_.hardness(unknowns.number.size()), stiffness, threads, execution)) {
    uses_ = grouped<Index>(unknowns_.free.size(), [&](const auto& visit) {
        execution.check();
        for (std::size_t point = 0; point < rows_.points.size(); ++point) {
            const Index number = unknowns_.number[rows_.points[point]];
            if (number >= 0) visit(number, static_cast<Index>(point));
        }
    });
}

DeformationEnergy::Workspace DeformationEnergy::make_workspace() const {
    Workspace workspace;
    workspace.shares.resize(rows_.points.size());
    workspace.block_energy.resize(rows_.block_count());
    return workspace;
}

double DeformationEnergy::evaluate(const PositionsView& positions, double rigidity, Positions& gradient, int threads,
                                   const Execution& execution, Workspace& workspace) const {
    const EnergyBlocks& rows = workspace.rows ? *workspace.rows : rows_;
    const double stretching = rigidity * rows.stretching;
    if (workspace.scratch.size() < static_cast<std::size_t>(threads)) workspace.scratch.resize(threads);
    parallel_items(rows.block_count(), threads, execution, [&](int worker, std::size_t block) {
        workspace.block_energy[block] =
            evaluate_block(rows, block, positions, stretching,
                           workspace.shares.data() + rows.blocks[block].first_point, workspace.scratch[worker]);
    });
    parallel_for(static_cast<Index>(unknowns_.free.size()), threads, execution, [&](Index begin, Index end) {
        for (Index number = begin; number < end; ++number) {
            double sum[3] = {0.0, 0.0, 0.0};
            for (const Index point : uses_.of(number)) {
                for (int c = 0; c < 3; ++c)
                    sum[c] += workspace.shares[point].value[c];
            }
            gradient.row(number) << sum[0], sum[1], sum[2];
        }
    });
    double sum = std::accumulate(workspace.block_energy.begin(), workspace.block_energy.end(), 0.0);
    if (!soft_constraints_.empty())
        sum += soft_constraints_.add_energy(positions, workspace.soft_targets, workspace.soft_weights, gradient,
                                            threads, execution);
    return sum;
}

void DeformationEnergy::refill(const Encoding& encoding, const RestCells& cells, int threads,
                               const Execution& execution, Workspace& workspace) const {
    if (!workspace.rows) workspace.rows = rows_;
    refill_energy_blocks(encoding, unknowns_, cells, threads, execution, *workspace.rows);
}

double DeformationEnergy::evaluate_block(const EnergyBlocks& rows, std::size_t block, const PositionsView& positions,
                                         double stretching, PaddedPoint* shares, Workspace::Scratch& scratch) const {
    const EnergyBlock& begin = rows.blocks[block];
    const EnergyBlock& end = rows.blocks[block + 1];
    scratch.positions.resize(rows.largest_block);
    const Index* const points = rows.points.data() + begin.first_point;
    for (std::int64_t k = 0; k < end.first_point - begin.first_point; ++k) {
        const double* const position = positions.data() + positions.outerStride() * points[k];
        scratch.positions[k] = {{position[0], position[1], position[2], 0.0}};
        shares[k] = {};
    }
    scratch.kernel.resize(rows.longest_ring);
    return kernel_(rows.batches.data() + begin.first_batch, static_cast<Index>(end.first_batch - begin.first_batch),
                   rows.rings(), scratch.positions.data(), stretching, scratch.kernel, shares);
}

}  // namespace meanvalue
