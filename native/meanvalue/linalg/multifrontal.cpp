#include "meanvalue/linalg/multifrontal.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "meanvalue/common/grouped.h"
#include "meanvalue/linalg/supernodal_pattern.h"

namespace meanvalue {
namespace {

struct NotPositiveDefinite {};

// Blocks of rows between two checks for cancellation; their columns stay in the processor's second cache meanwhile.
constexpr Index kBlocksPerPiece = 16;

struct Entry {
    Index row;
    double value;
};

/// The lower triangle of the matrix in the order of elimination, by columns.
Grouped<Entry> in_order(const SparseMatrix& lower, const std::vector<Index>& order, const Execution& execution) {
    const auto size = static_cast<Index>(order.size());
    std::vector<Index> place(size);
    for (Index k = 0; k < size; ++k)
        place[order[k]] = k;
    return grouped<Entry>(size, [&](const auto& visit) {
        for (Index column = 0; column < size; ++column) {
            execution.check_every(column);
            for (SparseMatrix::InnerIterator entry(lower, column); entry; ++entry) {
                if (entry.row() < column) continue;
                const auto ends = std::minmax(place[entry.row()], place[column]);
                visit(ends.first, {ends.second, entry.value()});
            }
        }
    });
}

/// What a supernode leaves, in the shape of its front.
using Rest = std::unique_ptr<double[]>;

class Fronts {
  public:
    Fronts(const SupernodalPattern& pattern, const SparseMatrix& lower, const FrontKernels& kernels,
           const PanelSink& sink, const Execution& execution)
        : pattern_(pattern),
          kernels_(kernels),
          sink_(sink),
          execution_(execution),
          matrix_(in_order(lower, pattern.order, execution)),
          rests_(pattern.count()),
          children_(grouped<Index>(pattern.count(), [&](const auto& visit) {
              for (Index s = 0; s < pattern.count(); ++s) {
                  if (pattern.parents[s] >= 0) visit(pattern.parents[s], s);
              }
          })) {}

    /// What one thread works with.
    struct Worker {
        std::vector<Index> position;  // of a row of the factor in the front
        std::vector<std::int64_t> places;
        std::vector<Index> of_child;
        std::unique_ptr<double[]> panel;
        std::int64_t panel_room = 0;
        double reciprocals[SupernodalPattern::kMostColumns];
    };

    void eliminate(Index s, Worker& worker) {
        execution_.check();
        const FrontShape shape{pattern_.width(s), pattern_.row_count(s) - pattern_.width(s)};
        assemble(s, shape, worker);
        if (!kernels_.factor_top(shape, worker.panel.get(), worker.reciprocals)) throw NotPositiveDefinite();
        for (Index block = 0; block < shape.below_blocks(); block += kBlocksPerPiece) {
            execution_.check();
            const Index end = std::min(block + kBlocksPerPiece, shape.below_blocks());
            kernels_.solve_below(shape, worker.panel.get(), worker.reciprocals, block, end);
        }
        sink_(s, shape, worker.panel.get());
        for (Index block = 0; block < shape.below_blocks(); block += kBlocksPerPiece) {
            execution_.check();
            const Index end = std::min(block + kBlocksPerPiece, shape.below_blocks());
            kernels_.update_rest(shape, worker.panel.get(), rests_[s].get(), block, end);
        }
    }

  private:
    void assemble(Index s, const FrontShape& shape, Worker& worker) {
        clear(s, shape, worker);
        const Index* const rows = pattern_.rows_of(s);
        worker.position.resize(pattern_.size());
        worker.places.resize(pattern_.row_count(s));
        for (Index k = 0; k < pattern_.row_count(s); ++k) {
            worker.position[rows[k]] = k;
            worker.places[k] = shape.place(k);
        }
        const Index first = pattern_.first_column[s];
        for (Index c = 0; c < shape.width; ++c) {
            double* const column = worker.panel.get() + c * kBlockRows;
            for (const Entry& entry : matrix_.of(first + c))
                column[worker.places[worker.position[entry.row]]] += entry.value;
        }
        for (const Index child : children_.of(s)) {
            add_child(child, s, shape, worker);
            rests_[child].reset();
        }
    }

    void clear(Index s, const FrontShape& shape, Worker& worker) {
        const std::int64_t panel_size = shape.panel_size();
        const std::int64_t stride = shape.rest_stride();
        if (worker.panel_room < panel_size) {
            worker.panel.reset(new double[panel_size]);
            worker.panel_room = panel_size;
        }
        rests_[s].reset(new double[stride * stride]);
        WorkMeter work(execution_);
        work.add(panel_size / 8);
        std::fill_n(worker.panel.get(), panel_size, 0.0);
        for (Index c = 0; c < stride; ++c) {
            const std::int64_t begin = c / kBlockRows * kBlockRows;
            work.add((stride - begin) / 2);  // where it is new memory
            std::fill(rests_[s].get() + c * stride + begin, rests_[s].get() + (c + 1) * stride, 0.0);
        }
    }

    void add_child(Index child, Index s, const FrontShape& shape, Worker& worker) {
        const Index width = pattern_.width(child);
        const Index count = pattern_.row_count(child) - width;
        const Index* const rows = pattern_.rows_of(child) + width;
        worker.of_child.resize(count);
        for (Index k = 0; k < count; ++k)
            worker.of_child[k] = worker.position[rows[k]];
        const std::int64_t child_stride = FrontShape{width, count}.rest_stride();
        const Index* const to = worker.of_child.data();
        WorkMeter work(execution_);
        for (Index c = 0; c < count; ++c) {
            work.add(count);
            const double* const from = rests_[child].get() + c * child_stride;
            if (to[c] < shape.width) {
                double* const column = worker.panel.get() + std::int64_t{to[c]} * kBlockRows;
                for (Index k = c; k < count; ++k)
                    column[worker.places[to[k]]] += from[k];
            } else {
                const std::int64_t column = (to[c] - shape.width) * shape.rest_stride() - shape.width;
                for (Index k = c; k < count; ++k)
                    rests_[s][column + to[k]] += from[k];
            }
        }
    }

    const SupernodalPattern& pattern_;
    const FrontKernels& kernels_;
    const PanelSink& sink_;
    const Execution& execution_;
    Grouped<Entry> matrix_;
    std::vector<Rest> rests_;  // of each supernode, until its parent has taken it
    Grouped<Index> children_;
};

/// In the units of cut_into_tasks().
std::vector<std::int64_t> weights_of(const SupernodalPattern& pattern) {
    constexpr std::int64_t kWorkPerUnit = 4;
    constexpr std::int64_t kUnitsPerRow = 20;
    std::vector<std::int64_t> weights(pattern.count());
    for (Index s = 0; s < pattern.count(); ++s)
        weights[s] = pattern.work(s) / kWorkPerUnit + kUnitsPerRow * pattern.row_count(s);
    return weights;
}

}  // namespace

bool factor_fronts(const SupernodalPattern& pattern, SparseMatrix lower, const FrontKernels& kernels, int threads,
                   const PanelSink& sink, const Execution& execution) {
    Fronts fronts(pattern, lower, kernels, sink, execution);
    SparseMatrix().swap(lower);
    const std::vector<EliminationTask> tasks = cut_into_tasks(pattern.parents, weights_of(pattern));
    std::vector<Fronts::Worker> workers(threads);
    const auto eliminate = [&](Index task, int worker) {
        for (Index s = tasks[task].begin; s < tasks[task].end; ++s)
            fronts.eliminate(s, workers[worker]);
    };
    try {
        run_tasks(tasks, threads, execution, eliminate, [](Index, int) {});
    } catch (const NotPositiveDefinite&) {
        return false;
    }
    return true;
}

}  // namespace meanvalue
