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
    pattern_.reset();
    values_.reset();
    try {
        auto pattern = std::make_shared<const SupernodalPattern>(find_supernodes(lower, threads, execution, order));
        order_ = pattern->order;
        build_supernodes(*pattern, execution);
        place_rows(*pattern, execution);
        pattern_ = std::move(pattern);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "analyse");
    }
}

SupernodalFactor SupernodalFactor::of_same_pattern() const {
    SupernodalFactor other(instructions_);
    other.pattern_ = pattern_;
    other.order_ = order_;
    other.supernodes_ = supernodes_;
    other.below_ = below_;
    other.tasks_ = tasks_;
    other.update_rows_ = update_rows_;
    other.value_count_ = value_count_;
    other.row_count_ = row_count_;
    other.most_blocks_ = most_blocks_;
    return other;
}

void SupernodalFactor::build_supernodes(const SupernodalPattern& pattern, const Execution& execution) {
    supernodes_.resize(pattern.count());
    std::vector<std::int64_t> weights(pattern.count());
    std::int64_t below = 0;
    most_blocks_ = 0;
    value_count_ = 0;
    for (Index s = 0; s < pattern.count(); ++s) {
        execution.check_every(s);
        const Index width = pattern.width(s);
        const Index row_count = pattern.row_count(s);
        supernodes_[s] = {pattern.first_column[s], width, row_count, below, value_count_};
        below += row_count - width;
        value_count_ += lanes_of(width, row_count);
        most_blocks_ = std::max(most_blocks_, block_count(row_count));
        weights[s] = pattern.panel_size(s);
    }
    below_.resize(below);
    tasks_ = cut_into_tasks(pattern.parents, weights);
}

void SupernodalFactor::place_rows(const SupernodalPattern& pattern, const Execution& execution) {
    update_rows_.assign(tasks_.size(), {});
    std::vector<std::vector<Index>> rows(tasks_.size());  // outside of each task, ascending
    std::vector<Index> place(size());
    std::vector<Index> seen_by(size(), -1);
    Index next_place = size();
    const auto each_row_below = [&](Index task, const auto& action) {
        for (Index s = tasks_[task].begin; s < tasks_[task].end; ++s) {
            execution.check_every(s);
            const Index* row = pattern.rows_of(s) + supernodes_[s].width;
            for (Index k = 0; k < supernodes_[s].row_count - supernodes_[s].width; ++k)
                action(supernodes_[s].first_below + k, row[k]);
        }
    };
    // The parent of a task comes after it: from the last to the first, its rows are known.
    for (auto task = static_cast<Index>(tasks_.size()) - 1; task >= 0; --task) {
        const Supernode& last = supernodes_[tasks_[task].end - 1];
        const Index end = last.first_column + last.width;
        each_row_below(task, [&](std::int64_t, Index row) {
            if (row < end || seen_by[row] == task) return;
            seen_by[row] = task;
            rows[task].push_back(row);
        });
        std::sort(rows[task].begin(), rows[task].end());
        update_rows_[task].place = next_place;
        for (const Index row : rows[task])
            place[row] = next_place++;
        each_row_below(task, [&](std::int64_t k, Index row) { below_[k] = row < end ? row : place[row]; });

        const Index parent = tasks_[task].parent;
        if (parent < 0) continue;
        const Supernode& last_of_parent = supernodes_[tasks_[parent].end - 1];
        const Index end_of_parent = last_of_parent.first_column + last_of_parent.width;
        for (const Index row : rows[task]) {
            const auto found = std::lower_bound(rows[parent].begin(), rows[parent].end(), row);
            update_rows_[task].in_parent.push_back(
                row < end_of_parent ? row
                                    : update_rows_[parent].place + static_cast<Index>(found - rows[parent].begin()));
        }
    }
    row_count_ = next_place;
}

bool SupernodalFactor::factorise(const SparseMatrix& lower, const Execution& execution, int threads) {
    try {
        // Without writing to it: a fresh gigabyte takes longer to touch than a cancel may wait.
        if (!values_) values_.reset(new Lanes[value_count_]);
        // In double precision only what is being worked on.
        std::vector<std::vector<double>> panels(threads);
        const PanelSink sink{
            [&](Index s, int worker) {
                std::vector<double>& panel = panels[worker];
                panel.resize(std::max(panel.size(), static_cast<std::size_t>(pattern_->panel_size(s))));
                return panel.data();
            },
            [&](Index s, int worker) {
                pack(supernodes_[s], panels[worker].data(), &values_[supernodes_[s].values]);
            }};
        return factor_fronts(*pattern_, lower, front_kernels(instructions_), threads, sink, execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "factor");
    }
}

void SupernodalFactor::solve(const PositionsView& right_hand_sides, Eigen::Ref<Positions> solution, int threads,
                             const Execution& execution, Workspace& workspace) const {
    const auto worthwhile = static_cast<int>(std::min<std::int64_t>(1 + value_count_ / kLanesPerThread, 1024));
    const int workers = std::min({threads, worthwhile, std::max(1, static_cast<int>(tasks_.size()))});
    const std::size_t numbers = static_cast<std::size_t>(row_count_) * kStride;
    if (workspace.rows.size() < numbers) workspace.rows.resize(numbers);
    if (workspace.blocks.size() < static_cast<std::size_t>(workers)) workspace.blocks.resize(workers);
    for (std::vector<Lanes>& blocks : workspace.blocks) {
        if (blocks.size() < 3 * static_cast<std::size_t>(most_blocks_)) blocks.resize(3 * most_blocks_);
    }
    workspace.scale = scale_of(right_hand_sides);
    workspace.runner.run(
        tasks_, workers, execution,
        [&](Index task, int worker) { forward(right_hand_sides, task, worker, execution, workspace); },
        [&](Index task, int worker) { backward(solution, task, worker, execution, workspace); });
}

void SupernodalFactor::forward(const PositionsView& right_hand_sides, Index task, int worker,
                               const Execution& execution, Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = tasks_[task];
    const Supernode& last = supernodes_[nodes.end - 1];
    for (Index k = supernodes_[nodes.begin].first_column; k < last.first_column + last.width; ++k) {
        for (int side = 0; side < 3; ++side)
            workspace.row(k)[side] = static_cast<float>(workspace.scale * right_hand_sides(order_[k], side));
    }
    const UpdateRows& updates = update_rows_[task];
    std::fill_n(workspace.row(updates.place), updates.in_parent.size() * kStride, 0.0F);
    for (const Index child : nodes.children) {
        const float* from = workspace.row(update_rows_[child].place);
        for (const Index place : update_rows_[child].in_parent) {
            for (int side = 0; side < 3; ++side)
                workspace.row(place)[side] += from[side];
            from += kStride;
        }
    }
    const auto kernel = supernode_kernels(instructions_).forward;
    for (Index s = nodes.begin; s < nodes.end; ++s) {
        execution.check();
        const Supernode& node = supernodes_[s];
        kernel(node, &values_[node.values], below_.data() + node.first_below, workspace.blocks[worker].data(),
               workspace.rows.data());
    }
}

void SupernodalFactor::backward(Eigen::Ref<Positions> solution, Index task, int worker, const Execution& execution,
                                Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = tasks_[task];
    float* to = workspace.row(update_rows_[task].place);
    for (const Index place : update_rows_[task].in_parent) {
        std::copy_n(workspace.row(place), kStride, to);
        to += kStride;
    }
    const auto kernel = supernode_kernels(instructions_).backward;
    for (Index s = nodes.end - 1; s >= nodes.begin; --s) {
        execution.check();
        const Supernode& node = supernodes_[s];
        kernel(node, &values_[node.values], below_.data() + node.first_below, workspace.blocks[worker].data(),
               workspace.rows.data());
    }
    const Supernode& last = supernodes_[nodes.end - 1];
    for (Index k = supernodes_[nodes.begin].first_column; k < last.first_column + last.width; ++k) {
        for (int side = 0; side < 3; ++side)
            solution(order_[k], side) = workspace.row(k)[side] / workspace.scale;
    }
}

std::size_t SupernodalFactor::bytes() const {
    std::size_t bytes = value_count_ * sizeof(Lanes) + supernodes_.size() * sizeof(Supernode) +
                        (order_.size() + below_.size()) * sizeof(Index);
    for (const UpdateRows& updates : update_rows_)
        bytes += updates.in_parent.size() * sizeof(Index);
    return bytes;
}

std::size_t SupernodalFactor::workspace_bytes() const {
    return static_cast<std::size_t>(row_count_) * kStride * sizeof(float) +
           3 * static_cast<std::size_t>(most_blocks_) * sizeof(Lanes);
}

}  // namespace meanvalue
