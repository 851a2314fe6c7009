// The order of elimination and what follows from it: graph, minimum degree, separators, dissection, tree, supernodes.
#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "meanvalue/linalg/dissection_tree.h"
#include "meanvalue/linalg/elimination_tree.h"
#include "meanvalue/linalg/graph.h"
#include "meanvalue/linalg/minimum_degree.h"
#include "meanvalue/linalg/nested_dissection.h"
#include "meanvalue/linalg/separator.h"
#include "meanvalue/linalg/supernodal_pattern.h"
#include "tests/matrices.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

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
    EXPECT_EQ(std::vector<Index>(graph.begin(0), graph.end(0)), (std::vector<Index>{1, 2, 3, 4}));
    for (Index v = 1; v < 5; ++v)
        EXPECT_EQ(std::vector<Index>(graph.begin(v), graph.end(v)), std::vector<Index>{0});
}

TEST(Graph, ColumnsWithTheSameEntriesAreOneVertex) {
    const SparseMatrix lower = bilaplacian(grid(12, 9, 0.1));
    const Graph columns = graph_of(in_blocks(lower), Execution());
    const VertexGroups groups = group_same_columns(columns, Execution());
    const Graph of_blocks = contracted(columns, groups, Execution());
    const Graph of_vertices = graph_of(lower, Execution());
    ASSERT_EQ(of_blocks.size(), of_vertices.size());
    EXPECT_EQ(of_blocks.total_weight(), 3 * of_vertices.total_weight());
    EXPECT_EQ(of_blocks.neighbours.size(), of_vertices.neighbours.size());
    for (Index group = 0; group < groups.count(); ++group) {
        EXPECT_EQ(groups.members[3 * group] + 1, groups.members[3 * group + 1]);
        EXPECT_EQ(groups.members[3 * group] + 2, groups.members[3 * group + 2]);
    }
    EXPECT_EQ(group_same_columns(graph_of(full(30), Execution()), Execution()).count(), 1);
    EXPECT_EQ(group_same_columns(graph_of(diagonal(30), Execution()), Execution()).count(), 30);
}

TEST(MinimumDegree, EliminatesLeavesOfATreeFirst) {
    MinimumDegree minimum_degree;
    minimum_degree.reset(5, 6);  // a star about 0, and what stays beside it
    for (Index leaf = 1; leaf < 5; ++leaf)
        minimum_degree.connect(0, leaf);
    minimum_degree.connect(4, 5);
    const std::vector<Index> order = minimum_degree.order();
    EXPECT_EQ((std::vector<Index>(order.begin(), order.begin() + 3)), (std::vector<Index>{1, 2, 3}));
    EXPECT_TRUE(is_permutation(order, 5));
}

TEST(Separator, LeavesNoEdgeBetweenItsSides) {
    SeparatorFinder finder;
    for (const Mesh& mesh : {grid(60, 40, 0.0), torus(60, 40), sphere(5)}) {
        const Graph graph = graph_of(bilaplacian(mesh), Execution());
        const Separation found = finder.find(graph, Execution());
        std::array<std::int64_t, 3> weight = {};
        for (Index v = 0; v < graph.size(); ++v) {
            weight[found.side[v]] += graph.weights[v];
            for (const Index* u = graph.begin(v); u != graph.end(v); ++u)
                EXPECT_TRUE(found.side[v] == kSeparator || found.side[*u] == kSeparator ||
                            found.side[v] == found.side[*u]);
        }
        EXPECT_EQ(weight, found.weight);
        EXPECT_GT(std::min(weight[kLeft], weight[kRight]), graph.total_weight() / 4) << mesh.name;
        EXPECT_LT(weight[kSeparator], graph.size() / 8) << mesh.name;
        EXPECT_EQ(finder.find(graph, Execution()).side, found.side);
    }
}

TEST(Separator, TwoRowsOfVerticesCutAGrid) {
    const Graph graph = graph_of(bilaplacian(grid(100, 20, 0.0)), Execution());
    EXPECT_LE(SeparatorFinder().find(graph, Execution()).weight[kSeparator], 44);
}

std::int64_t fill_of(const SparseMatrix& lower, const std::vector<Index>& order) {
    return find_supernodes(lower, 1, Execution(), order).entry_count();
}

TEST(DissectionTree, LeadsAGraphAlongAnotherOfFewerAndOtherVertices) {
    const Index side = 60;
    const SparseMatrix fine = bilaplacian(grid(side, side, 0.1));
    DissectionTree tree;
    const std::vector<Index> order = nested_dissection(graph_of(fine, Execution()), 3, Execution(), &tree);
    std::vector<Index> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<Index>(k);

    const Index rows = static_cast<Index>(order.size()) / side;
    ASSERT_EQ(rows * side, fine.cols());
    // Every other vertex of every other row: of the separators hardly anything is left.
    const Index few = (side + 1) / 2;
    const SparseMatrix coarse = bilaplacian(grid(few, (rows + 1) / 2, 0.1));
    std::vector<Index> places;
    for (Index row = 0; row < rows; row += 2) {
        for (Index column = 0; column < side; column += 2)
            places.push_back(place[row * side + column]);
    }
    ASSERT_EQ(static_cast<Index>(places.size()), coarse.cols());
    const Graph graph = graph_of(coarse, Execution());
    const std::vector<Index> along = nested_dissection_along(tree, places, graph, 1, Execution());
    EXPECT_TRUE(is_permutation(along, graph.size()));
    EXPECT_EQ(nested_dissection_along(tree, places, graph, 3, Execution()), along);
    const auto own = static_cast<double>(fill_of(coarse, nested_dissection(graph, 1, Execution())));
    EXPECT_LT(static_cast<double>(fill_of(coarse, along)), 1.15 * own);
}

TEST(DissectionTree, WhereItTellsNothingSeparatorsAreSoughtAfresh) {
    const SparseMatrix lower = bilaplacian(grid(40, 40, 0.1));
    const Graph graph = graph_of(lower, Execution());
    std::vector<Index> places(graph.size());
    std::iota(places.begin(), places.end(), 0);
    const DissectionTree one_part({}, graph.size());
    EXPECT_EQ(nested_dissection_along(one_part, places, graph, 1, Execution()),
              nested_dissection(graph, 1, Execution()));
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
    EXPECT_LE(entries, pattern.entry_count());
    EXPECT_LE(pattern.entry_count(), 2 * entries + 10 * pattern.size());
}

TEST_P(FillOf, ColumnCountsAreThoseOfTheFilledMatrix) {
    const SparseMatrix& lower = GetParam().lower;
    const Graph graph = graph_of(lower, Execution());
    EliminationOrder order(nested_dissection(graph, 1, Execution()));
    std::vector<Index> parents = elimination_tree(graph, order, Execution());
    const std::vector<Index> places = postorder(parents, std::vector<Index>(graph.size(), 0), Execution());
    order.rearrange(places);
    parents = renamed_forest(parents, places);
    const std::vector<Index> counts = column_counts(graph, order, parents, Execution());
    const std::vector<std::set<Index>> filled = filled_columns(lower, order.vertex);
    for (Index k = 0; k < graph.size(); ++k) {
        ASSERT_EQ(counts[k], static_cast<Index>(filled[k].size()));
        ASSERT_EQ(parents[k], filled[k].size() < 2 ? -1 : *std::next(filled[k].begin()));
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
            const EliminationOrder order(pattern.order);
            const std::vector<Index> counts =
                column_counts(graph, order, elimination_tree(graph, order, Execution()), Execution());
            const std::int64_t entries = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
            EXPECT_LE(entries, pattern.entry_count());
            EXPECT_LE(pattern.entry_count(), entries + entries / 3) << mesh.name << ", " << seed;
        }
    }
}

TEST(NestedDissection, FillsLittle) {
    const SupernodalPattern pattern = find_supernodes(bilaplacian(grid(60, 60, 0.1)), 1, Execution());
    EXPECT_LT(pattern.entry_count(), 85 * pattern.size());
}

TEST(Ordering, CanBeCancelledAtEveryLook) {
    const SparseMatrix lower = bilaplacian(grid(50, 40, 0.1));
    for (std::int64_t look = 1;; look = look + 1 + look / 3) {
        Execution execution;
        execution.cancel_at_look(look);
        try {
            find_supernodes(lower, 2, execution);
        } catch (const Cancelled&) {
            continue;
        }
        EXPECT_GT(look, 10);
        break;
    }
}

}  // namespace
}  // namespace meanvalue::tests
