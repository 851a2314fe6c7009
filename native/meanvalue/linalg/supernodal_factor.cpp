#include "meanvalue/linalg/supernodal_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "meanvalue/linalg/multifrontal.h"
#include "meanvalue/linalg/sparse_cholesky.h"

namespace meanvalue {
namespace {

// A thread is worth starting for so many lanes of values: some 50 microseconds of work.
constexpr std::int64_t kLanesPerThread = 1 << 15;
/// A power of two that takes the largest number near 1: single precision has a short range of exponents.
double scale_of(const PositionsView& numbers) {
    const double largest = numbers.size() == 0 ? 0.0 : numbers.cwiseAbs().maxCoeff();
    if (!(largest > 0.0) || !std::isfinite(largest)) return 1.0;
    return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1000, 1000));
}

}  // namespace

void SupernodalFactor::analyse(const SparseMatrix& lower, const Execution& execution, int threads,
                               const std::vector<Index>& order) {
    analysis_.reset();
    values_.reset();
    try {
        analysis_ = std::make_shared<const Analysis>(find_supernodes(lower, threads, execution, order), execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "analyse");
    }
}

SupernodalFactor SupernodalFactor::of_same_pattern() const {
    SupernodalFactor other(instructions_);
    other.analysis_ = analysis_;
    return other;
}

SupernodalFactor::Analysis::Analysis(SupernodalPattern found, const Execution& execution)
    : pattern(std::move(found)) {
    build_supernodes();
    place_rows(execution);
}

void SupernodalFactor::Analysis::build_supernodes() {
    supernodes.resize(pattern.count());
    std::vector<std::int64_t> weights(pattern.count());
    std::int64_t below_count = 0;
    most_blocks = 0;
    value_count = 0;
    for (Index s = 0; s < pattern.count(); ++s) {
        const Index width = pattern.width(s);
        const Index row_count = pattern.row_count(s);
        supernodes[s] = {pattern.first_column[s], width, row_count, below_count, value_count};
        below_count += row_count - width;
        value_count += lanes_of(width, row_count);
        most_blocks = std::max(most_blocks, block_count(row_count));
        weights[s] = pattern.panel_size(s);
    }
    below.resize(below_count);
    tasks = cut_into_tasks(pattern.parents, weights);
}

void SupernodalFactor::Analysis::place_rows(const Execution& execution) {
    update_rows.assign(tasks.size(), {});
    std::vector<std::vector<Index>> rows(tasks.size());  // outside of each task, ascending
    std::vector<Index> place(pattern.size());
    std::vector<Index> seen_by(pattern.size(), -1);
    Index next_place = pattern.size();
    const auto each_row_below = [&](Index task, const auto& action) {
        for (Index s = tasks[task].begin; s < tasks[task].end; ++s) {
            execution.check_every(s);
            const Index* row = pattern.rows_of(s) + supernodes[s].width;
            for (Index k = 0; k < supernodes[s].row_count - supernodes[s].width; ++k)
                action(supernodes[s].first_below + k, row[k]);
        }
    };
    // The parent of a task comes after it: from the last to the first, its rows are known.
    for (auto task = static_cast<Index>(tasks.size()) - 1; task >= 0; --task) {
        const Supernode& last = supernodes[tasks[task].end - 1];
        const Index end = last.first_column + last.width;
        each_row_below(task, [&](std::int64_t, Index row) {
            if (row < end || seen_by[row] == task) return;
            seen_by[row] = task;
            rows[task].push_back(row);
        });
        std::sort(rows[task].begin(), rows[task].end());
        update_rows[task].place = next_place;
        for (const Index row : rows[task])
            place[row] = next_place++;
        each_row_below(task, [&](std::int64_t k, Index row) { below[k] = row < end ? row : place[row]; });

        const Index parent = tasks[task].parent;
        if (parent < 0) continue;
        const Supernode& last_of_parent = supernodes[tasks[parent].end - 1];
        const Index end_of_parent = last_of_parent.first_column + last_of_parent.width;
        for (const Index row : rows[task]) {
            const auto found = std::lower_bound(rows[parent].begin(), rows[parent].end(), row);
            update_rows[task].in_parent.push_back(
                row < end_of_parent ? row
                                    : update_rows[parent].place + static_cast<Index>(found - rows[parent].begin()));
        }
    }
    row_count = next_place;
}

bool SupernodalFactor::factorise(const SparseMatrix& lower, const Execution& execution, int threads) {
    try {
        // Without writing to it: a fresh gigabyte takes longer to touch than a cancel may wait.
        if (!values_) values_.reset(new Lanes[analysis_->value_count]);
        // In double precision only what is being worked on.
        const auto keep = [&](Index s, const FrontShape& shape, const double* panel) {
            pack(shape, panel, &values_[analysis_->supernodes[s].values]);
        };
        return factor_fronts(analysis_->pattern, lower, front_kernels(instructions_), threads, keep, execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "factor");
    }
}

void SupernodalFactor::solve(const PositionsView& right_hand_sides, Eigen::Ref<Positions> solution, int threads,
                             const Execution& execution, Workspace& workspace) const {
    const auto worthwhile =
        static_cast<int>(std::min<std::int64_t>(1 + analysis_->value_count / kLanesPerThread, 1024));
    const int workers = std::min({threads, worthwhile, std::max(1, static_cast<int>(analysis_->tasks.size()))});
    const std::size_t numbers = static_cast<std::size_t>(analysis_->row_count) * kStride;
    if (workspace.rows.size() < numbers) workspace.rows.resize(numbers);
    if (workspace.blocks.size() < static_cast<std::size_t>(workers)) workspace.blocks.resize(workers);
    for (std::vector<Lanes>& blocks : workspace.blocks) {
        if (blocks.size() < 3 * static_cast<std::size_t>(analysis_->most_blocks))
            blocks.resize(3 * analysis_->most_blocks);
    }
    workspace.scale = scale_of(right_hand_sides);
    workspace.runner.run(
        analysis_->tasks, workers, execution,
        [&](Index task, int worker) { forward(right_hand_sides, task, worker, execution, workspace); },
        [&](Index task, int worker) { backward(solution, task, worker, execution, workspace); });
}

void SupernodalFactor::forward(const PositionsView& right_hand_sides, Index task, int worker,
                               const Execution& execution, Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = analysis_->tasks[task];
    const Supernode& last = analysis_->supernodes[nodes.end - 1];
    for (Index k = analysis_->supernodes[nodes.begin].first_column; k < last.first_column + last.width; ++k) {
        for (int side = 0; side < 3; ++side)
            workspace.row(k)[side] =
                static_cast<float>(workspace.scale * right_hand_sides(analysis_->pattern.order[k], side));
    }
    const UpdateRows& updates = analysis_->update_rows[task];
    std::fill_n(workspace.row(updates.place), updates.in_parent.size() * kStride, 0.0F);
    for (const Index child : nodes.children) {
        const float* from = workspace.row(analysis_->update_rows[child].place);
        for (const Index place : analysis_->update_rows[child].in_parent) {
            for (int side = 0; side < 3; ++side)
                workspace.row(place)[side] += from[side];
            from += kStride;
        }
    }
    const auto kernel = supernode_kernels(instructions_).forward;
    for (Index s = nodes.begin; s < nodes.end; ++s) {
        execution.check();
        const Supernode& node = analysis_->supernodes[s];
        kernel(node, &values_[node.values], analysis_->below.data() + node.first_below,
               workspace.blocks[worker].data(), workspace.rows.data());
    }
}

void SupernodalFactor::backward(Eigen::Ref<Positions> solution, Index task, int worker, const Execution& execution,
                                Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = analysis_->tasks[task];
    float* to = workspace.row(analysis_->update_rows[task].place);
    for (const Index place : analysis_->update_rows[task].in_parent) {
        std::copy_n(workspace.row(place), kStride, to);
        to += kStride;
    }
    const auto kernel = supernode_kernels(instructions_).backward;
    for (Index s = nodes.end - 1; s >= nodes.begin; --s) {
        execution.check();
        const Supernode& node = analysis_->supernodes[s];
        kernel(node, &values_[node.values], analysis_->below.data() + node.first_below,
               workspace.blocks[worker].data(), workspace.rows.data());
    }
    const Supernode& last = analysis_->supernodes[nodes.end - 1];
    for (Index k = analysis_->supernodes[nodes.begin].first_column; k < last.first_column + last.width; ++k) {
        for (int side = 0; side < 3; ++side)
            solution(analysis_->pattern.order[k], side) = workspace.row(k)[side] / workspace.scale;
    }
}

std::size_t SupernodalFactor::bytes() const {
    if (!analysis_) return 0;
    std::size_t bytes = analysis_->value_count * sizeof(Lanes) + analysis_->supernodes.size() * sizeof(Supernode) +
                        (analysis_->pattern.order.size() + analysis_->below.size()) * sizeof(Index);
    for (const UpdateRows& updates : analysis_->update_rows)
        bytes += updates.in_parent.size() * sizeof(Index);
    return bytes;
}

std::size_t SupernodalFactor::workspace_bytes() const {
    if (!analysis_) return 0;
    return static_cast<std::size_t>(analysis_->row_count) * kStride * sizeof(float) +
           3 * static_cast<std::size_t>(analysis_->most_blocks) * sizeof(Lanes);
}

}  // namespace meanvalue
