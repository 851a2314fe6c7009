#include "meanvalue/paper/gauss_newton_system.h"

#include <algorithm>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue {

GaussNewtonSystem::GaussNewtonSystem(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution)
    : encoding_(encoding), unknowns_(unknowns) {
    term_offsets_.push_back(0);
    for (const Index i : unknowns_.rows) {
        execution.check_every(term_offsets_.size());
        // The vertex's own term first, then its ring in order: linearise() relies on it.
        if (unknowns_.number[i] >= 0) term_columns_.push_back(unknowns_.number[i]);
        for (Index k = encoding_.ring_offsets[i]; k < encoding_.ring_offsets[i + 1]; ++k) {
            const Index column = unknowns_.number[encoding_.ring[k]];
            if (column >= 0) term_columns_.push_back(column);
        }
        term_offsets_.push_back(static_cast<std::int64_t>(term_columns_.size()));
    }
    find_pattern(execution);
    fill_smoothness_metric(execution);
}

void GaussNewtonSystem::find_pattern(const Execution& execution) {
    // Of A^T A, entry (a, b) is there where a row of A has terms in both columns.
    WorkMeter work(execution);
    std::vector<std::vector<Index>> columns(unknowns_.free.size());
    for (std::size_t k = 0; k < columns.size(); ++k)
        columns[k].push_back(static_cast<Index>(k));
    for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
        for (std::int64_t a = term_offsets_[row]; a < term_offsets_[row + 1]; ++a) {
            work.add(term_offsets_[row + 1] - term_offsets_[row]);
            for (std::int64_t b = term_offsets_[row]; b < term_offsets_[row + 1]; ++b) {
                if (term_columns_[a] > term_columns_[b]) columns[term_columns_[b]].push_back(term_columns_[a]);
            }
        }
    }
    for (std::vector<Index>& column : columns) {
        work.add(8 * column.size());
        std::sort(column.begin(), column.end());
        column.erase(std::unique(column.begin(), column.end()), column.end());
    }
    pattern_ = BlockMatrix(columns, execution);
    pair_offsets_.push_back(0);
    for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
        execution.check_every(row);
        for (std::int64_t a = term_offsets_[row]; a < term_offsets_[row + 1]; ++a) {
            for (std::int64_t b = term_offsets_[row]; b < term_offsets_[row + 1]; ++b) {
                if (term_columns_[a] < term_columns_[b]) continue;
                pair_positions_.push_back(pattern_.find(term_columns_[a], term_columns_[b]));
            }
        }
        pair_offsets_.push_back(static_cast<std::int64_t>(pair_positions_.size()));
    }
}

void GaussNewtonSystem::fill_smoothness_metric(const Execution& execution) {
    smoothness_metric_.assign(pattern_.block_count(), 0.0);
    std::vector<double> coefficients;
    for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
        execution.check_every(row);
        const Index i = unknowns_.rows[row];
        coefficients.clear();
        if (unknowns_.number[i] >= 0) coefficients.push_back(1.0);
        for (Index k = encoding_.ring_offsets[i]; k < encoding_.ring_offsets[i + 1]; ++k) {
            if (unknowns_.number[encoding_.ring[k]] >= 0) coefficients.push_back(-encoding_.weights[k]);
        }
        std::int64_t pair = pair_offsets_[row];
        const std::int64_t first = term_offsets_[row];
        for (std::size_t a = 0; a < coefficients.size(); ++a) {
            for (std::size_t b = 0; b < coefficients.size(); ++b) {
                if (term_columns_[first + a] < term_columns_[first + b]) continue;
                smoothness_metric_[pair_positions_[pair++]] += coefficients[a] * coefficients[b];
            }
        }
    }
}

GaussNewtonSystem::Workspace GaussNewtonSystem::make_workspace(const Execution& execution) const {
    return {pattern_.with_same_pattern(execution),
            Eigen::VectorXd(3 * static_cast<Eigen::Index>(unknowns_.free.size())),
            std::vector<Matrix3>(term_columns_.size()), std::vector<Vector3>(unknowns_.rows.size())};
}

double GaussNewtonSystem::energy(const PositionsView& positions, int threads, const Execution& execution,
                                 Workspace& workspace) const {
    parallel_for(static_cast<Index>(unknowns_.rows.size()), threads, execution, [&](Index begin, Index end) {
        for (Index row = begin; row < end; ++row) {
            const Index i = unknowns_.rows[row];
            workspace.residuals[row] = Vector3(positions.row(i)) - predict(encoding_.ring_of(i), positions);
        }
    });
    double sum = 0.0;
    for (const Vector3& residual : workspace.residuals)
        sum += residual.squaredNorm();
    return 0.5 * sum;
}

void GaussNewtonSystem::linearise(const PositionsView& positions, const Positions* fixed_moves, int threads,
                                  const Execution& execution, Workspace& workspace) const {
    parallel_for(static_cast<Index>(unknowns_.rows.size()), threads, execution, [&](Index begin, Index end) {
        std::vector<Matrix3> blocks;
        for (Index row = begin; row < end; ++row) {
            const Index i = unknowns_.rows[row];
            const EncodedRing ring = encoding_.ring_of(i);
            blocks.resize(ring.valence);
            Vector3 residual = Vector3(positions.row(i)) - predict_with_jacobian(ring, positions, blocks.data());
            std::int64_t term = term_offsets_[row];
            const auto add_term = [&](Index vertex, const Matrix3& block) {
                if (unknowns_.number[vertex] >= 0) {
                    workspace.term_blocks[term++] = block;
                } else if (fixed_moves != nullptr) {
                    residual += block * fixed_moves->row(vertex).transpose();
                }
            };
            add_term(i, Matrix3::Identity());
            for (Index k = 0; k < ring.valence; ++k)
                add_term(ring.ring[k], -blocks[k]);
            workspace.residuals[row] = residual;
        }
    });
    assemble(execution, workspace);
}

void GaussNewtonSystem::assemble(const Execution& execution, Workspace& workspace) const {
    const std::vector<Matrix3>& blocks = workspace.term_blocks;
    workspace.matrix.set_zero(execution);
    workspace.gradient.setZero();
    for (std::size_t row = 0; row < unknowns_.rows.size(); ++row) {
        execution.check_every(row);
        std::int64_t pair = pair_offsets_[row];
        for (std::int64_t a = term_offsets_[row]; a < term_offsets_[row + 1]; ++a) {
            workspace.gradient.segment<3>(3 * term_columns_[a]) += blocks[a].transpose() * workspace.residuals[row];
            for (std::int64_t b = term_offsets_[row]; b < term_offsets_[row + 1]; ++b) {
                if (term_columns_[a] < term_columns_[b]) continue;
                workspace.matrix.add(pair_positions_[pair++], term_columns_[b], blocks[a].transpose() * blocks[b]);
            }
        }
    }
}

}  // namespace meanvalue
