#include "meanvalue/linalg/supernodal_pattern.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/linalg/elimination_tree.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/nested_dissection.h"

namespace meanvalue {
namespace {

/// A graph of groups of columns, with the tree of their elimination.
struct Elimination {
    const Graph& graph;
    const std::vector<Index>& first_column;  // of each group, then the number of columns
    EliminationTree tree;

    /// Columns of a node of the tree.
    Index weight(Index node) const {
        const Index group = tree.vertex[node];
        return first_column[group + 1] - first_column[group];
    }
};

/// Consecutive nodes of the tree; first those with the very same rows, then merged where that costs few zeros.
class SupernodeMerging {
  public:
    explicit SupernodeMerging(const Elimination& elimination) : elimination_(elimination) {
        find_fundamental();
        const auto count = static_cast<Index>(begin_.size());
        for (Index s = count - 2; s >= 0; --s) {
            const Index parent = elimination.tree.parents[begin_[s + 1] - 1];
            if (parent < 0 || supernode_of_[parent] >= end_[s + 1]) continue;  // not what it would be merged with
            if (worth_merging(s)) merge(s);
        }
    }

    /// The first nodes.
    std::vector<Index> begins() const {
        std::vector<Index> begins;
        for (std::size_t s = 0; s < begin_.size(); s = end_[s])
            begins.push_back(begin_[s]);
        return begins;
    }

  private:
    void find_fundamental() {
        const auto size = static_cast<Index>(elimination_.tree.parents.size());
        std::vector<Index> children(size, 0);
        for (const Index parent : elimination_.tree.parents) {
            if (parent >= 0) ++children[parent];
        }
        supernode_of_.resize(size);
        for (Index node = 0; node < size; ++node) {
            const bool goes_on =
                node > 0 && elimination_.tree.parents[node - 1] == node && children[node] == 1 &&
                elimination_.tree.counts[node - 1] == elimination_.tree.counts[node] + elimination_.weight(node - 1);
            if (!goes_on) {
                begin_.push_back(node);
                columns_.push_back(0);
            }
            columns_.back() += elimination_.weight(node);
            supernode_of_[node] = static_cast<Index>(begin_.size()) - 1;
        }
        end_.resize(begin_.size());
        std::iota(end_.begin(), end_.end(), 1);
        zeros_.assign(begin_.size(), 0.0);
        for (const Index begin : begin_)
            rows_.push_back(elimination_.tree.counts[begin]);
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

    const Elimination& elimination_;
    std::vector<Index> begin_;  // the fundamental supernodes
    std::vector<Index> supernode_of_;
    std::vector<Index> end_;  // behind the last that is merged into each
    std::vector<double> columns_;
    std::vector<double> rows_;  // with its columns
    std::vector<double> zeros_;
    double new_zeros_ = 0.0;
};

/// Rows of each supernode in nodes, then written down in columns.
class PatternBuilder {
  public:
    PatternBuilder(const Elimination& elimination, const std::vector<Index>& begins)
        : elimination_(elimination), begins_(begins), size_(static_cast<Index>(elimination.tree.parents.size())) {
        column_.reserve(size_ + 1);
        for (Index node = 0; node < size_; ++node) {
            column_.push_back(static_cast<Index>(pattern_.order.size()));
            const Index vertex = elimination.tree.vertex[node];
            for (Index k = elimination.first_column[vertex]; k < elimination.first_column[vertex + 1]; ++k)
                pattern_.order.push_back(k);
        }
        column_.push_back(static_cast<Index>(pattern_.order.size()));
    }

    SupernodalPattern build(const Execution& execution) {
        const auto count = static_cast<Index>(begins_.size());
        supernode_of_.resize(size_);
        for (Index s = 0; s < count; ++s)
            std::fill(supernode_of_.begin() + begins_[s], supernode_of_.begin() + end(s), s);
        first_child_.assign(count, -1);
        next_sibling_.assign(count, -1);
        seen_by_.assign(size_, -1);
        WorkMeter work(execution);
        for (Index s = 0; s < count; ++s) {
            find_rows(s, work);
            write_down(s);
            work.add(pattern_.row_count(pattern_.count() - 1));
        }
        find_parents();
        return std::move(pattern_);
    }

  private:
    Index end(Index s) const { return s + 1 < static_cast<Index>(begins_.size()) ? begins_[s + 1] : size_; }

    /// Nodes behind its own in which it has entries: the matrix's, and what its children leave.
    void find_rows(Index s, WorkMeter& work) {
        rows_.clear();
        const auto add = [&](Index node) {
            if (node < end(s) || seen_by_[node] == s) return;
            seen_by_[node] = s;
            rows_.push_back(node);
        };
        for (Index node = begins_[s]; node < end(s); ++node) {
            const Index vertex = elimination_.tree.vertex[node];
            work.add(4 + elimination_.graph.degree(vertex));
            for (const Index* u = elimination_.graph.begin(vertex); u != elimination_.graph.end(vertex); ++u)
                add(elimination_.tree.place[*u]);
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

    void write_down(Index s) {
        const Index end_column = column_[end(s)];
        for (Index first = column_[begins_[s]]; first < end_column; first = pattern_.first_column.back()) {
            for (Index column = first; column < end_column; ++column)
                pattern_.rows.push_back(column);
            for (const Index node : rows_) {
                for (Index column = column_[node]; column < column_[node + 1]; ++column)
                    pattern_.rows.push_back(column);
            }
            pattern_.first_column.push_back(std::min(first + SupernodalPattern::kMostColumns, end_column));
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

    const Elimination& elimination_;
    const std::vector<Index>& begins_;
    Index size_;
    std::vector<Index> column_;  // the first of each node
    std::vector<Index> supernode_of_;
    std::vector<Index> first_child_;
    std::vector<Index> next_sibling_;
    std::vector<Index> seen_by_;
    std::vector<Index> rows_;
    std::vector<Index> kept_rows_;  // of all supernodes
    std::vector<std::int64_t> kept_offsets_ = {0};
    SupernodalPattern pattern_;
};

/// The groups as their first columns come. @param order of all columns.
std::vector<Index> groups_in_order(const std::vector<Index>& first_column, const std::vector<Index>& order) {
    std::vector<Index> group_of(order.size(), -1);  // of first columns
    for (std::size_t group = 0; group + 1 < first_column.size(); ++group)
        group_of[first_column[group]] = static_cast<Index>(group);
    std::vector<Index> result;
    for (const Index column : order) {
        if (group_of[column] >= 0) result.push_back(group_of[column]);
    }
    return result;
}

}  // namespace

std::int64_t SupernodalPattern::work(Index supernode) const {
    const std::int64_t columns = width(supernode);
    const std::int64_t below = row_count(supernode) - columns;
    return columns * columns * columns / 3 + columns * below * (columns + below);
}

SupernodalPattern find_supernodes(const SparseMatrix& lower, int threads, const Execution& execution,
                                  const std::vector<Index>& order) {
    const Graph columns = graph_of(lower, execution);
    const std::vector<Index> first_column = group_same_columns(columns, execution);
    const Graph graph = contracted(columns, first_column, execution);
    std::vector<Index> widths(graph.size());
    std::adjacent_difference(first_column.begin() + 1, first_column.end(), widths.begin());
    std::vector<Index> group_order =
        order.empty() ? nested_dissection(graph, threads, execution) : groups_in_order(first_column, order);
    const Elimination elimination{graph, first_column,
                                  find_elimination_tree(graph, std::move(group_order), widths, execution)};
    return PatternBuilder(elimination, SupernodeMerging(elimination).begins()).build(execution);
}

}  // namespace meanvalue
