#include <algorithm>
#include <map>
#include <random>

#include "meanvalue/common/errors.h"
#include "meanvalue/mesh/same_places.h"
#include "tests/support.h"

namespace meanvalue::tests {
namespace {

using Edges = std::vector<std::pair<Index, Index>>;

Edges counted(const std::vector<Index>& corners, const std::vector<Index>& starts) {
    std::map<std::pair<Index, Index>, int> uses;
    for (std::size_t face = 0; face < starts.size(); ++face) {
        const std::size_t end = face + 1 < starts.size() ? starts[face + 1] : corners.size();
        for (std::size_t k = starts[face]; k < end; ++k) {
            const Index from = corners[k], to = corners[k + 1 < end ? k + 1 : starts[face]];
            if (from != to) ++uses[{std::min(from, to), std::max(from, to)}];
        }
    }
    Edges alone;
    for (const auto& [edge, count] : uses) {
        if (count == 1) alone.push_back(edge);
    }
    return alone;
}

TEST(BorderEdges, AreThoseThatOneFaceHasWhereverItLooks) {
    const std::vector<Index> corners{0, 1, 2, 3, 1, 2, 4, 1, 4, 5, 1, 2, 6, 0, 0};
    const std::vector<Index> starts{0, 4, 7, 10, 13};
    const Edges expected{{0, 1}, {0, 3}, {1, 5}, {1, 6}, {2, 3}, {2, 4}, {2, 6}, {4, 5}};
    EXPECT_EQ(border_edges(7, corners, starts, Execution()), expected);
    EXPECT_EQ(counted(corners, starts), expected);
    EXPECT_TRUE(border_edges(3, {}, {}, Execution()).empty());
}

TEST(BorderEdges, OfRandomFacesAreThoseThatCountingFinds) {
    std::mt19937 random(1);
    for (const Index count : {4, 30, 3000}) {
        std::vector<Index> corners, starts;
        for (int face = 0; face < 2000; ++face) {
            starts.push_back(static_cast<Index>(corners.size()));
            const Index from = static_cast<Index>(random() % static_cast<unsigned>(count));
            for (Index k = 0; k < 3 + face % 2; ++k)
                corners.push_back((from + (face % 5 == 0 ? 3 - k : k) * (1 + face % 3)) % count);
        }
        EXPECT_EQ(border_edges(count, corners, starts, Execution()), counted(corners, starts)) << count;
    }
}

TEST(Seams, JoinBordersAndWhatLiesOnASurfaceWithAllItsVertices) {
    const Mesh sheet = grid(5, 5, 0.0);
    const Index n = static_cast<Index>(sheet.vertices.rows());
    const auto joined = [&](const Positions& second, bool is_turned) {
        Positions points(2 * n, 3);
        points << sheet.vertices, second;
        std::vector<Index> corners, starts;
        for (Index f = 0; f < 2 * sheet.faces.rows(); ++f) {
            starts.push_back(3 * f);
            const bool is_second = f >= sheet.faces.rows();
            for (int k = 0; k < 3; ++k) {
                corners.push_back(sheet.faces(f % sheet.faces.rows(), is_second && is_turned ? 2 - k : k) +
                                  (is_second ? n : 0));
            }
        }
        const auto first = first_of_seams(points, corners, starts, 1e-6, Execution());
        return std::count_if(first.begin() + n, first.end(), [&](Index v) { return v < n; });
    };
    Positions raised = sheet.vertices;
    raised(12, 2) += 0.1;
    for (const bool is_turned : {false, true}) {
        EXPECT_EQ(joined(sheet.vertices, is_turned), 25);
        EXPECT_EQ(joined(raised, is_turned), 16);  // the borders
        EXPECT_EQ(joined(sheet.vertices.array() + 0.1, is_turned), 0);
    }
}

TEST(Seams, AttachACornerOfABorderToTheFirstSurfaceThatItIsInside) {
    const Mesh sheet = grid(5, 5, 0.0);
    for (const Index wing : {0, 25}) {  // before the sheet that it is on, and after
        const Index low = wing == 0 ? 3 : 0, high = 28, loose = 53;
        Positions points(54, 3);
        points.middleRows(low, 25) = points.middleRows(high, 25) = sheet.vertices;
        points.middleRows(high, 25).col(2).array() += 1.0;
        for (const Index v : {high + 12, wing, wing + 1, wing + 2, loose})
            points.row(v) = sheet.vertices.row(12);
        points.row(wing + 1).array() += 2.0;
        points.row(wing + 2) << 2.0, 3.0, 4.0;
        std::vector<Index> corners{wing, wing + 1, wing + 2}, starts{0};
        for (const Index begin : {low, high}) {
            for (Index f = 0; f < sheet.faces.rows(); ++f) {
                starts.push_back(static_cast<Index>(corners.size()));
                for (const Index v : sheet.faces.row(f))
                    corners.push_back(begin + v);
            }
        }
        const auto first = first_of_seams(points, corners, starts, 1e-6, Execution());
        for (Index v = 0; v < 54; ++v)
            EXPECT_EQ(first[v], v == wing || v == low + 12 ? std::min(wing, low + 12) : v) << v;
    }
}

TEST(BorderEdges, OfNoMeshAreRefused) {
    EXPECT_THROW(border_edges(3, {0, 1, 3}, {0}, Execution()), InvalidInput);
    EXPECT_THROW(border_edges(3, {0, 1, -1}, {0}, Execution()), InvalidInput);
    EXPECT_THROW(border_edges(3, {0, 1, 2}, {4}, Execution()), InvalidInput);
    EXPECT_THROW(border_edges(3, {0, 1, 2}, {-1}, Execution()), InvalidInput);
    EXPECT_THROW(border_edges(3, {0, 1, 2}, {2, 0}, Execution()), InvalidInput);
}

}  // namespace
}  // namespace meanvalue::tests
