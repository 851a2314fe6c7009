#include "meanvalue/linalg/supernodal_pattern.h"

#include <algorithm>
#include <utility>

#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/nested_dissection.h"

namespace meanvalue {
namespace {

/// Consecutive columns.
struct Columns {
    Index begin;
    double count;
    double rows;  // of the first column, with its own
    double zeros;
};

/// The first columns of supernodes, and the number of all columns. Those with the very same rows are together, and
/// what is merged with them at the cost of few zeros.
///
/// The limits are CHOLMOD's (Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887, ACM Trans. Math.
/// Softw. 35, 2008); docs/decisions/0010-own-cholesky.md measures others.
std::vector<Index> find_begins(const EliminationTree& tree) {
    const auto size = static_cast<Index>(tree.parents.size());
    std::vector<Index> children(size, 0);
    for (const Index parent : tree.parents) {
        if (parent >= 0) ++children[parent];
    }
    std::vector<Columns> found;  // the last columns first
    for (Index end = size, begin = 0; end > 0; end = begin) {
        for (begin = end - 1; begin > 0 && children[begin] == 1 && tree.parents[begin - 1] == begin &&
                              tree.counts[begin - 1] == tree.counts[begin] + 1;)
            --begin;
        const double count = end - begin;
        found.push_back({begin, count, static_cast<double>(tree.counts[begin]), 0.0});
        if (found.size() == 1) continue;
        Columns& above = found[found.size() - 2];
        const Index parent = tree.parents[end - 1];
        if (parent < 0 || parent >= above.begin + above.count) continue;  // not what it would be merged with
        const double merged = count + above.count;
        const double new_zeros = merged <= 4 ? 0.0 : count * (above.rows + count - found.back().rows);
        const double entries = merged * (merged + 1) / 2 + merged * (above.rows - above.count);
        const double share = (above.zeros + new_zeros) / entries;
        if (new_zeros == 0.0 || (merged <= 16 && share < 0.8) || (merged <= 48 && share < 0.1) || share < 0.05) {
            // What it has is among what is above, with all that was merged into that.
            above = {begin, merged, count + above.rows, above.zeros + new_zeros};
            found.pop_back();
        }
    }
    std::vector<Index> begins;
    for (auto each = found.rbegin(); each != found.rend(); ++each) {
        // As a chain of supernodes where they are too many for one.
        for (Index column = 0; column < static_cast<Index>(each->count); column += SupernodalPattern::kMostColumns)
            begins.push_back(each->begin + column);
    }
    begins.push_back(size);
    return begins;
}

/// The rows of each supernode below its own columns: those that the matrix has, and what its children leave.
SupernodalPattern find_rows(const Graph& graph, const EliminationTree& tree, const Execution& execution) {
    SupernodalPattern pattern;
    pattern.order = tree.vertex;
    pattern.first_column = find_begins(tree);
    pattern.parents.assign(pattern.count(), -1);
    std::vector<Index> owner(graph.size());  // of each column
    for (Index s = 0; s < pattern.count(); ++s)
        std::fill(owner.begin() + pattern.first_column[s], owner.begin() + pattern.first_column[s + 1], s);
    // Lists of children.
    std::vector<Index> first_child(pattern.count(), -1);
    std::vector<Index> next_sibling(pattern.count(), -1);
    std::vector<Index> seen_by(graph.size(), -1);
    std::vector<Index> below;
    WorkMeter work(execution);
    for (Index s = 0; s < pattern.count(); ++s) {
        const Index end = pattern.first_column[s + 1];
        below.clear();
        const auto add = [&](Index row) {
            if (row < end || std::exchange(seen_by[row], s) == s) return;
            below.push_back(row);
        };
        for (Index column = pattern.first_column[s]; column < end; ++column) {
            pattern.rows.push_back(column);
            const auto neighbours = graph.of(tree.vertex[column]);
            work.add(4 + neighbours.size());
            for (const Index u : neighbours)
                add(tree.place[u]);
        }
        for (Index child = first_child[s]; child >= 0; child = next_sibling[child]) {
            work.add(pattern.row_count(child));
            std::for_each(pattern.rows_of(child) + pattern.width(child), pattern.rows_of(child + 1), add);
        }
        std::sort(below.begin(), below.end());
        pattern.rows.insert(pattern.rows.end(), below.begin(), below.end());
        pattern.first_row.push_back(static_cast<std::int64_t>(pattern.rows.size()));
        if (below.empty()) continue;
        pattern.parents[s] = owner[below.front()];
        next_sibling[s] = std::exchange(first_child[pattern.parents[s]], s);
    }
    pattern.rows.shrink_to_fit();
    return pattern;
}

}  // namespace

std::int64_t SupernodalPattern::work(Index supernode) const {
    const std::int64_t columns = width(supernode);
    const std::int64_t below = row_count(supernode) - columns;
    return columns * columns * columns / 3 + columns * below * (columns + below);
}

SupernodalPattern find_supernodes(const SparseMatrix& lower, int threads, const Execution& execution,
                                  const std::vector<Index>& order) {
    const Graph graph = graph_of(lower, execution);
    return find_rows(
        graph,
        find_elimination_tree(graph, order.empty() ? nested_dissection(graph, threads, execution) : order, execution),
        execution);
}

}  // namespace meanvalue
