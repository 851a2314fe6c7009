#include "meanvalue/linalg/supernodal_pattern.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/linalg/elimination_tree.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/nested_dissection.h"

namespace meanvalue {
namespace {

/// Consecutive columns; first those with the very same rows, then merged where that costs few zeros.
class SupernodeMerging {
  public:
    explicit SupernodeMerging(const EliminationTree& tree) : tree_(tree) {
        find_fundamental();
        const auto count = static_cast<Index>(begin_.size());
        for (Index s = count - 2; s >= 0; --s) {
            const Index parent = tree.parents[begin_[s + 1] - 1];
            if (parent < 0 || supernode_of_[parent] >= end_[s + 1]) continue;  // not what it would be merged with
            if (worth_merging(s)) merge(s);
        }
    }

    /// The first columns.
    std::vector<Index> begins() const {
        std::vector<Index> begins;
        for (std::size_t s = 0; s < begin_.size(); s = end_[s])
            begins.push_back(begin_[s]);
        return begins;
    }

  private:
    void find_fundamental() {
        const auto size = static_cast<Index>(tree_.parents.size());
        std::vector<Index> children(size, 0);
        for (const Index parent : tree_.parents) {
            if (parent >= 0) ++children[parent];
        }
        supernode_of_.resize(size);
        for (Index column = 0; column < size; ++column) {
            const bool goes_on = column > 0 && tree_.parents[column - 1] == column && children[column] == 1 &&
                                 tree_.counts[column - 1] == tree_.counts[column] + 1;
            if (!goes_on) {
                begin_.push_back(column);
                columns_.push_back(0);
            }
            ++columns_.back();
            supernode_of_[column] = static_cast<Index>(begin_.size()) - 1;
        }
        end_.resize(begin_.size());
        std::iota(end_.begin(), end_.end(), 1);
        zeros_.assign(begin_.size(), 0.0);
        for (const Index begin : begin_)
            rows_.push_back(tree_.counts[begin]);
    }

    /// The limits are CHOLMOD's (Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887, ACM Trans. Math.
    /// Softw. 35, 2008); docs/decisions/0006-single-precision-factor.md measures others.
    bool worth_merging(Index s) {
        const double columns = columns_[s];
        const double merged = columns + columns_[s + 1];
        const double rows_above = rows_[s + 1];
        const double new_zeros = columns * (rows_above + columns - rows_[s]);
        if (merged <= 4) {
            new_zeros_ = 0.0;
            return true;
        }
        new_zeros_ = new_zeros;
        if (new_zeros == 0.0) return true;
        const double size = merged * (merged + 1) / 2 + merged * (rows_above - columns_[s + 1]);
        const double share = (zeros_[s + 1] + new_zeros) / size;
        return (merged <= 16 && share < 0.8) || (merged <= 48 && share < 0.1) || share < 0.05;
    }

    /// s + 1, and what that was merged with, into s.
    void merge(Index s) {
        zeros_[s] = zeros_[s + 1] + new_zeros_;
        // What s has is among what s + 1 has, with all that was merged into that.
        rows_[s] = columns_[s] + rows_[s + 1];
        columns_[s] += columns_[s + 1];
        end_[s] = end_[s + 1];
    }

    const EliminationTree& tree_;
    std::vector<Index> begin_;  // the fundamental supernodes
    std::vector<Index> supernode_of_;
    std::vector<Index> end_;  // behind the last that is merged into each
    std::vector<double> columns_;
    std::vector<double> rows_;  // with its columns
    std::vector<double> zeros_;
    double new_zeros_ = 0.0;
};

/// Finds the rows of each supernode.
class PatternBuilder {
  public:
    PatternBuilder(const Graph& graph, const EliminationTree& tree, const std::vector<Index>& begins)
        : graph_(graph), tree_(tree), begins_(begins) {
        pattern_.order = tree.vertex;
    }

    SupernodalPattern build(const Execution& execution) {
        const auto count = static_cast<Index>(begins_.size());
        supernode_of_.resize(graph_.size());
        for (Index s = 0; s < count; ++s)
            std::fill(supernode_of_.begin() + begins_[s], supernode_of_.begin() + end(s), s);
        first_child_.assign(count, -1);
        next_sibling_.assign(count, -1);
        seen_by_.assign(graph_.size(), -1);
        WorkMeter work(execution);
        for (Index s = 0; s < count; ++s) {
            find_rows(s, work);
            write_down(s);
            work.add(pattern_.row_count(pattern_.count() - 1));
        }
        pattern_.rows.shrink_to_fit();
        find_parents();
        return std::move(pattern_);
    }

  private:
    Index end(Index s) const { return s + 1 < static_cast<Index>(begins_.size()) ? begins_[s + 1] : graph_.size(); }

    /// Rows below its own columns in which it has entries: the matrix's, and what its children leave.
    void find_rows(Index s, WorkMeter& work) {
        rows_.clear();
        const auto add = [&](Index row) {
            if (row < end(s) || seen_by_[row] == s) return;
            seen_by_[row] = s;
            rows_.push_back(row);
        };
        for (Index column = begins_[s]; column < end(s); ++column) {
            const Index vertex = tree_.vertex[column];
            work.add(4 + graph_.degree(vertex));
            for (const Index* u = graph_.begin(vertex); u != graph_.end(vertex); ++u)
                add(tree_.place[*u]);
        }
        for (Index child = first_child_[s]; child >= 0; child = next_sibling_[child]) {
            work.add(kept_offsets_[child + 1] - kept_offsets_[child]);
            for (std::int64_t k = kept_offsets_[child]; k < kept_offsets_[child + 1]; ++k)
                add(kept_rows_[k]);
        }
        std::sort(rows_.begin(), rows_.end());
        kept_rows_.insert(kept_rows_.end(), rows_.begin(), rows_.end());
        kept_offsets_.push_back(static_cast<std::int64_t>(kept_rows_.size()));
        if (rows_.empty()) return;
        const Index parent = supernode_of_[rows_.front()];
        next_sibling_[s] = std::exchange(first_child_[parent], s);
    }

    /// As a chain of supernodes where it is too wide for one.
    void write_down(Index s) {
        for (Index first = begins_[s]; first < end(s); first = pattern_.first_column.back()) {
            for (Index column = first; column < end(s); ++column)
                pattern_.rows.push_back(column);
            pattern_.rows.insert(pattern_.rows.end(), rows_.begin(), rows_.end());
            pattern_.first_column.push_back(std::min(first + SupernodalPattern::kMostColumns, end(s)));
            pattern_.first_row.push_back(static_cast<std::int64_t>(pattern_.rows.size()));
        }
    }

    void find_parents() {
        std::vector<Index> owner(pattern_.size());
        for (Index s = 0; s < pattern_.count(); ++s)
            std::fill(owner.begin() + pattern_.first_column[s], owner.begin() + pattern_.first_column[s + 1], s);
        pattern_.parents.assign(pattern_.count(), -1);
        for (Index s = 0; s < pattern_.count(); ++s) {
            if (pattern_.row_count(s) > pattern_.width(s))
                pattern_.parents[s] = owner[pattern_.rows_of(s)[pattern_.width(s)]];
        }
    }

    const Graph& graph_;
    const EliminationTree& tree_;
    const std::vector<Index>& begins_;
    std::vector<Index> supernode_of_;
    std::vector<Index> first_child_;
    std::vector<Index> next_sibling_;
    std::vector<Index> seen_by_;
    std::vector<Index> rows_;
    std::vector<Index> kept_rows_;  // of all supernodes
    std::vector<std::int64_t> kept_offsets_ = {0};
    SupernodalPattern pattern_;
};

}  // namespace

std::int64_t SupernodalPattern::work(Index supernode) const {
    const std::int64_t columns = width(supernode);
    const std::int64_t below = row_count(supernode) - columns;
    return columns * columns * columns / 3 + columns * below * (columns + below);
}

SupernodalPattern find_supernodes(const SparseMatrix& lower, int threads, const Execution& execution,
                                  const std::vector<Index>& order) {
    const Graph graph = graph_of(lower, execution);
    const EliminationTree tree =
        find_elimination_tree(graph, order.empty() ? nested_dissection(graph, threads, execution) : order, execution);
    return PatternBuilder(graph, tree, SupernodeMerging(tree).begins()).build(execution);
}

}  // namespace meanvalue
