#include "meanvalue/linalg/supernodal_factor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "meanvalue/common/errors.h"
#include "meanvalue/linalg/multifrontal.h"

namespace meanvalue {
namespace {

// A thread is worth starting for so many lanes of values: some 50 microseconds of work.
constexpr std::int64_t kLanesPerThread = 1 << 15;

/// Numbers too small for a normal float count as zero on this thread while it lives: what decays away from a handle
/// ends in them, and they take a hundred times as long.
struct FlushDenormals {
#if defined(__x86_64__)
    static constexpr unsigned kFlushResultsAndOperands = 0x8040;
    const unsigned before = _mm_getcsr();
    FlushDenormals() {
        _mm_setcsr(before | kFlushResultsAndOperands);
    }
    ~FlushDenormals() {
        _mm_setcsr(before);
    }
#else
    FlushDenormals() {}
#endif
};

/// A power of two that takes the largest number near 1: single precision has a short range of exponents.
double scale_of(const PositionsView& numbers) {
    const double largest = numbers.size() == 0 ? 0.0 : numbers.cwiseAbs().maxCoeff();
    if (!(largest > 0.0) || !std::isfinite(largest)) return 1.0;
    return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1000, 1000));
}

[[noreturn]] void throw_too_large(Eigen::Index unknowns, Eigen::Index entries, const char* action) {
    throw SolverFailure(message("too little memory to ", action, " a linear system of ", unknowns, " unknowns with ",
                                entries, " entries; restrict the region of influence"));
}

/// The values of a supernode from the panel of its front, of which nothing above the diagonal is read.
template <typename Number>
void pack(const FrontShape& shape, const double* panel, Lanes<Number>* values) {
    constexpr Index kPerBlock = kLanes<Number>;
    const Index row_count = shape.width + shape.below;
    const auto entry = [&](Index row, Index column) {
        return panel[shape.place(row) + std::int64_t{column} * kBlockRows];
    };
    for (Index column = 0; column < shape.width; column += kGroup) {
        const Index end = std::min(column + kGroup, shape.width);
        Number corner[kCornerLanes<Number> * kPerBlock] = {};
        Number* below = corner + kGroup;
        for (Index c = column; c < end; ++c) {
            corner[c - column] = static_cast<Number>(1.0 / entry(c, c));
            for (Index r = c + 1; r < end; ++r)
                *below++ = static_cast<Number>(entry(r, c));
        }
        std::memcpy(values, corner, sizeof(corner));
        values += kCornerLanes<Number>;
        for (Index row = first_block<Number>(end) * kPerBlock; row < row_count; row += kPerBlock) {
            const Index first = std::max(row, end);
            const Index behind = std::min(row + kPerBlock, row_count);
            std::int64_t places[kPerBlock];
            for (Index r = first; r < behind; ++r)
                places[r - row] = shape.place(r);
            const double* from = panel + std::int64_t{column} * kBlockRows;
            for (Index c = column; c < end; ++c, ++values, from += kBlockRows) {
                *values = {};
                for (Index lane = first - row; lane < behind - row; ++lane)
                    values->value[lane] = static_cast<Number>(from[places[lane]]);
            }
        }
    }
}

}  // namespace

template <typename Number>
void CholeskyFactor<Number>::analyse(const SparseMatrix& lower, const Execution& execution, int threads,
                                     const std::vector<Index>& order) {
    analysis_.reset();
    values_.reset();
    try {
        analysis_ = std::make_shared<const Analysis>(find_supernodes(lower, threads, execution, order), execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower.rows(), lower.nonZeros(), "analyse");
    }
}

template <typename Number>
CholeskyFactor<Number> CholeskyFactor<Number>::with_same_pattern() const {
    CholeskyFactor other(instructions_);
    other.analysis_ = analysis_;
    return other;
}

template <typename Number>
CholeskyFactor<Number>::Analysis::Analysis(SupernodalPattern found, const Execution& execution)
    : pattern(std::move(found)) {
    supernodes.resize(pattern.count());
    std::vector<std::int64_t> weights(pattern.count());
    std::int64_t below_count = 0;
    for (Index s = 0; s < pattern.count(); ++s) {
        const Index width = pattern.width(s);
        const Index row_count = pattern.row_count(s);
        supernodes[s] = {pattern.first_column[s], width, row_count, below_count, value_count};
        below_count += row_count - width;
        value_count += lanes_of<Number>(width, row_count);
        most_blocks = std::max(most_blocks, block_count<Number>(row_count));
        weights[s] = pattern.panel_size(s);
    }
    below.resize(below_count);
    tasks = cut_into_tasks(pattern.parents, weights);
    place_rows(execution);
}

template <typename Number>
void CholeskyFactor<Number>::Analysis::place_rows(const Execution& execution) {
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

template <typename Number>
bool CholeskyFactor<Number>::factorise(SparseMatrix lower, const Execution& execution, int threads) {
    const Eigen::Index entries = lower.nonZeros();
    try {
        // Without writing to it: a fresh gigabyte takes longer to touch than a cancel may wait.
        if (!values_) values_.reset(new Lanes<Number>[analysis_->value_count]);
        // In double precision only what is being worked on.
        const auto keep = [&](Index s, const FrontShape& shape, const double* panel) {
            pack(shape, panel, &values_[analysis_->supernodes[s].values]);
        };
        return factor_fronts(analysis_->pattern, std::move(lower), front_kernels(instructions_), threads, keep,
                             execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(size(), entries, "factor");
    }
}

template <typename Number>
void CholeskyFactor<Number>::solve(const PositionsView& right_hand_sides, Eigen::Ref<Positions> solution, int threads,
                                   const Execution& execution, Workspace& workspace) const {
    const auto worthwhile =
        static_cast<int>(std::min<std::int64_t>(1 + analysis_->value_count / kLanesPerThread, 1024));
    const int workers = std::min({threads, worthwhile, std::max(1, static_cast<int>(analysis_->tasks.size()))});
    const std::size_t numbers = static_cast<std::size_t>(analysis_->row_count) * kStride;
    if (workspace.rows.size() < numbers) workspace.rows.resize(numbers);
    if (workspace.blocks.size() < static_cast<std::size_t>(workers)) workspace.blocks.resize(workers);
    for (std::vector<Lanes<Number>>& blocks : workspace.blocks) {
        if (blocks.size() < 3 * static_cast<std::size_t>(analysis_->most_blocks))
            blocks.resize(3 * analysis_->most_blocks);
    }
    workspace.scale = scale_of(right_hand_sides);
    run_tasks(
        analysis_->tasks, workers, execution,
        [&](Index task, int worker) { forward(right_hand_sides, task, worker, execution, workspace); },
        [&](Index task, int worker) { backward(solution, task, worker, execution, workspace); });
}

template <typename Number>
Eigen::MatrixXd CholeskyFactor<Number>::solve(const Eigen::MatrixXd& right_hand_sides,
                                              const Execution& execution) const {
    Workspace workspace;
    Eigen::MatrixXd solution(right_hand_sides.rows(), right_hand_sides.cols());
    Positions three(right_hand_sides.rows(), 3);
    for (Eigen::Index first = 0; first < solution.cols(); first += 3) {
        const Eigen::Index count = std::min<Eigen::Index>(3, solution.cols() - first);
        execution.check();
        three.setZero();
        three.leftCols(count) = right_hand_sides.middleCols(first, count);
        solve(three, three, 1, execution, workspace);
        solution.middleCols(first, count) = three.leftCols(count);
    }
    return solution;
}

template <typename Number>
void CholeskyFactor<Number>::forward(const PositionsView& right_hand_sides, Index task, int worker,
                                     const Execution& execution, Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = analysis_->tasks[task];
    const Supernode& last = analysis_->supernodes[nodes.end - 1];
    for (Index k = analysis_->supernodes[nodes.begin].first_column; k < last.first_column + last.width; ++k) {
        for (int side = 0; side < 3; ++side)
            workspace.row(k)[side] =
                static_cast<Number>(workspace.scale * right_hand_sides(analysis_->pattern.order[k], side));
    }
    const UpdateRows& updates = analysis_->update_rows[task];
    std::fill_n(workspace.row(updates.place), updates.in_parent.size() * kStride, Number(0));
    for (const Index child : nodes.children) {
        const Number* from = workspace.row(analysis_->update_rows[child].place);
        for (const Index place : analysis_->update_rows[child].in_parent) {
            for (int side = 0; side < 3; ++side)
                workspace.row(place)[side] += from[side];
            from += kStride;
        }
    }
    const auto kernel = supernode_kernels<Number>(instructions_).forward;
    for (Index s = nodes.begin; s < nodes.end; ++s) {
        execution.check();
        const Supernode& node = analysis_->supernodes[s];
        kernel(node, &values_[node.values], analysis_->below.data() + node.first_below,
               workspace.blocks[worker].data(), workspace.rows.data());
    }
}

template <typename Number>
void CholeskyFactor<Number>::backward(Eigen::Ref<Positions>& solution, Index task, int worker,
                                      const Execution& execution, Workspace& workspace) const {
    const FlushDenormals flush;
    const EliminationTask& nodes = analysis_->tasks[task];
    Number* to = workspace.row(analysis_->update_rows[task].place);
    for (const Index place : analysis_->update_rows[task].in_parent) {
        std::copy_n(workspace.row(place), kStride, to);
        to += kStride;
    }
    const auto kernel = supernode_kernels<Number>(instructions_).backward;
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

template <typename Number>
std::size_t CholeskyFactor<Number>::bytes() const {
    if (!analysis_) return 0;
    return analysis_->value_count * sizeof(Lanes<Number>) +
           (analysis_->pattern.order.size() + analysis_->below.size()) * sizeof(Index);
}

template class CholeskyFactor<float>;
template class CholeskyFactor<double>;

}  // namespace meanvalue
