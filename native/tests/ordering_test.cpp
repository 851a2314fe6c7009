// The order of elimination and what follows from it: graph, separators, dissection, tree, supernodes.
#include <algorithm>
#include <numeric>
#include <set>

#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/nested_dissection.h"
#include "meanvalue/linalg/supernodal_pattern.h"
#include "tests/matrices.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

/// Of the factor, in triangles.
std::int64_t entry_count(const SupernodalPattern& pattern) {
    std::int64_t entries = 0;
    for (Index s = 0; s < pattern.count(); ++s)
        entries += pattern.panel_size(s) - std::int64_t{pattern.width(s)} * (pattern.width(s) - 1) / 2;
    return entries;
}

bool is_permutation(std::vector<Index> order, Index size) {
    std::sort(order.begin(), order.end());
    std::vector<Index> all(size);
    std::iota(all.begin(), all.end(), 0);
    return order == all;
}

/// The rows of each column of the factor, the diagonal too: elimination as it is defined.
std::vector<std::set<Index>> filled_columns(const SparseMatrix& lower, const std::vector<Index>& order) {
    std::vector<Index> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<Index>(k);
    std::vector<std::set<Index>> columns(order.size());
    for (Index k = 0; k < lower.cols(); ++k) {
        columns[place[k]].insert(place[k]);
        for (SparseMatrix::InnerIterator entry(lower, k); entry; ++entry) {
            if (entry.row() < k) continue;
            const auto ends = std::minmax(place[k], place[entry.row()]);
            columns[ends.first].insert(ends.second);
        }
    }
    for (std::set<Index>& column : columns) {
        if (column.size() < 2) continue;
        const Index parent = *std::next(column.begin());
        columns[parent].insert(std::next(column.begin()), column.end());
    }
    return columns;
}

TEST(Graph, HasAnEdgeForEachEntryBelowTheDiagonal) {
    const Graph graph = graph_of(arrow(5), Execution());
    EXPECT_EQ(graph.size(), 5);
    EXPECT_EQ(std::vector<Index>(graph.of(0).begin(), graph.of(0).end()), (std::vector<Index>{1, 2, 3, 4}));
    for (Index v = 1; v < 5; ++v)
        EXPECT_EQ(std::vector<Index>(graph.of(v).begin(), graph.of(v).end()), std::vector<Index>{0});
}

std::int64_t count_of(const std::vector<Side>& sides, Side side) {
    return std::count(sides.begin(), sides.end(), side);
}

void expect_separates(const Graph& graph, const std::vector<Side>& sides) {
    for (Index v = 0; v < graph.size(); ++v) {
        for (const Index u : graph.of(v))
            ASSERT_FALSE(sides[v] == Side::kLeft && sides[u] == Side::kRight);
    }
}

TEST(Separator, OfALargeGridIsAboutTwoRowsNearItsMiddle) {
    const Graph graph = graph_of(bilaplacian(grid(120, 400, 0.0)), Execution());
    const std::vector<Side> sides = balanced_separator(graph, Execution());
    expect_separates(graph, sides);
    EXPECT_LE(count_of(sides, Side::kBetween), 240);  // of 120 vertices each
    EXPECT_GE(count_of(sides, Side::kLeft), graph.size() / 5);
    EXPECT_GE(count_of(sides, Side::kRight), graph.size() / 5);
}

TEST(Separator, OfALargeStarIsItsMiddle) {
    const Graph graph = graph_of(arrow(40000), Execution());
    const std::vector<Side> sides = balanced_separator(graph, Execution());
    expect_separates(graph, sides);
    EXPECT_EQ(count_of(sides, Side::kBetween), 1);
    EXPECT_EQ(sides[0], Side::kBetween);
}

TEST(Order, OfALargeGridIsOneForAnyNumberOfThreads) {
    const Graph graph = graph_of(bilaplacian(grid(120, 400, 0.0)), Execution());
    const std::vector<Index> order = nested_dissection(graph, 1, Execution());
    EXPECT_TRUE(is_permutation(order, graph.size()));
    EXPECT_EQ(nested_dissection(graph, 3, Execution()), order);
}

class OrderOf : public testing::TestWithParam<Case> {};

TEST_P(OrderOf, IsOneForAnyNumberOfThreads) {
    const Graph graph = graph_of(GetParam().lower, Execution());
    const std::vector<Index> order = nested_dissection(graph, 1, Execution());
    EXPECT_TRUE(is_permutation(order, graph.size()));
    for (const int threads : {2, 3, 4})
        EXPECT_EQ(nested_dissection(graph, threads, Execution()), order);
}

INSTANTIATE_TEST_SUITE_P(Matrices, OrderOf, testing::ValuesIn(all_matrices()),
                         [](const auto& item) { return std::to_string(item.index); });

/// For what is compared with elimination as it is defined, which takes long.
std::vector<Case> small_matrices() {
    std::vector<Case> small = all_matrices();
    const auto is_large = [](const Case& item) { return item.lower.cols() > 10000; };
    small.erase(std::remove_if(small.begin(), small.end(), is_large), small.end());
    return small;
}

class FillOf : public testing::TestWithParam<Case> {};

TEST_P(FillOf, SupernodesHoldAllThatEliminationFills) {
    const SparseMatrix& lower = GetParam().lower;
    const SupernodalPattern pattern = find_supernodes(lower, 2, Execution());
    ASSERT_EQ(pattern.size(), lower.cols());
    EXPECT_TRUE(is_permutation(pattern.order, pattern.size()));
    EXPECT_EQ(pattern.first_column.back(), pattern.size());
    const std::vector<std::set<Index>> filled = filled_columns(lower, pattern.order);
    std::int64_t entries = 0;
    for (Index s = 0; s < pattern.count(); ++s) {
        const Index* const rows = pattern.rows_of(s);
        const Index* const end = rows + pattern.row_count(s);
        EXPECT_LE(pattern.width(s), SupernodalPattern::kMostColumns);
        EXPECT_TRUE(std::is_sorted(rows, end));
        for (Index c = 0; c < pattern.width(s); ++c) {
            const Index column = pattern.first_column[s] + c;
            ASSERT_EQ(rows[c], column);
            entries += static_cast<std::int64_t>(filled[column].size());
            EXPECT_TRUE(std::includes(rows, end, filled[column].begin(), filled[column].end()));
        }
        if (pattern.parents[s] < 0) {
            EXPECT_EQ(pattern.row_count(s), pattern.width(s));
        } else {
            EXPECT_GT(pattern.parents[s], s);
            const Index* const above = pattern.rows_of(pattern.parents[s]);
            EXPECT_TRUE(
                std::includes(above, above + pattern.row_count(pattern.parents[s]), rows + pattern.width(s), end));
        }
    }
    EXPECT_LE(entries, entry_count(pattern));
    EXPECT_LE(entry_count(pattern), 2 * entries + 10 * pattern.size());
}

TEST_P(FillOf, ColumnCountsAreThoseOfTheFilledMatrix) {
    const SparseMatrix& lower = GetParam().lower;
    const Graph graph = graph_of(lower, Execution());
    const EliminationTree tree = find_elimination_tree(graph, nested_dissection(graph, 1, Execution()), Execution());
    EXPECT_TRUE(is_permutation(tree.vertex, graph.size()));
    const std::vector<std::set<Index>> filled = filled_columns(lower, tree.vertex);
    for (Index k = 0; k < graph.size(); ++k) {
        ASSERT_EQ(tree.place[tree.vertex[k]], k);
        ASSERT_EQ(tree.counts[k], static_cast<Index>(filled[k].size()));
        ASSERT_EQ(tree.parents[k], filled[k].size() < 2 ? -1 : *std::next(filled[k].begin()));
    }
}

INSTANTIATE_TEST_SUITE_P(Matrices, FillOf, testing::ValuesIn(small_matrices()),
                         [](const auto& item) { return std::to_string(item.index); });

TEST(Supernodes, MergingAddsFewZerosHoweverManyAreMerged) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
        for (const Mesh& mesh :
             {sphere(5), torus(70 + 3 * static_cast<Index>(seed), 40), capped_tube(12, 300, 40.0)}) {
            const SparseMatrix lower = bilaplacian(mesh, seed);
            const SupernodalPattern pattern = find_supernodes(lower, 2, Execution());
            const Graph graph = graph_of(lower, Execution());
            const std::vector<Index> counts = find_elimination_tree(graph, pattern.order, Execution()).counts;
            const std::int64_t entries = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
            EXPECT_LE(entries, entry_count(pattern));
            EXPECT_LE(entry_count(pattern), entries + entries / 3) << mesh.name << ", " << seed;
        }
    }
}

TEST(Order, FillsLittle) {
    const auto entries_a_column = [](const Mesh& mesh) {
        const SupernodalPattern pattern = find_supernodes(bilaplacian(mesh), 1, Execution());
        return static_cast<double>(entry_count(pattern)) / pattern.size();
    };
    EXPECT_LT(entries_a_column(grid(60, 60, 0.1)), 73.0);
    EXPECT_LT(entries_a_column(capped_tube(30, 500, 40.0)), 85.0);
    EXPECT_LT(entries_a_column(sphere(5)), 100.0);
    EXPECT_LT(entries_a_column(torus(300, 200)), 168.0);
}

TEST(Ordering, CanBeCancelledAtEveryLook) {
    const SparseMatrix lower = bilaplacian(grid(150, 120, 0.1));
    for (std::int64_t check = 1;; check += 1 + check / 3) {
        Execution execution;
        execution.cancel_at_check(check);
        try {
            find_supernodes(lower, 2, execution);
        } catch (const Cancelled&) {
            continue;
        }
        EXPECT_GT(check, 10);
        break;
    }
}

}  // namespace
}  // namespace meanvalue::tests
