#include "meanvalue/linalg/graph.h"

#include <numeric>

namespace meanvalue {
Graph graph_of(const SparseMatrix& lower, const Execution& execution) {
    const auto size = static_cast<Index>(lower.cols());
    const auto each_edge = [&](const auto& action) {
        for (Index column = 0; column < size; ++column) {
            execution.check_every(column);
            for (std::int64_t k = lower.outerIndexPtr()[column]; k < lower.outerIndexPtr()[column + 1]; ++k) {
                const auto row = static_cast<Index>(lower.innerIndexPtr()[k]);
                if (row > column) action(row, column);
            }
        }
    };
    Graph graph;
    graph.offsets.assign(size + 1, 0);
    each_edge([&](Index row, Index column) {
        ++graph.offsets[row + 1];
        ++graph.offsets[column + 1];
    });
    std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
    graph.neighbours.resize(graph.offsets.back());
    std::vector<std::int64_t> next(graph.offsets.begin(), graph.offsets.end() - 1);
    // Column after column: what comes before a vertex is in its list before what comes after it, ascending.
    each_edge([&](Index row, Index column) {
        graph.neighbours[next[row]++] = column;
        graph.neighbours[next[column]++] = row;
    });
    return graph;
}

}  // namespace meanvalue
