#include "meanvalue/optimise/elimination_order.h"

#include <algorithm>

#include "meanvalue/common/grouped.h"
#include "meanvalue/linalg/nested_dissection.h"
#include "meanvalue/optimise/ring_limit.h"

namespace meanvalue {
namespace {

/// Vertices that are in one row are neighbours. Rows that are too long to be solved for unless most of their vertices
/// are fixed are left out: any order is one for them.
Graph graph_of_rows(const Encoding& encoding, const Execution& execution) {
    const Index count = encoding.vertex_count();
    const auto valence = [&](Index row) { return encoding.ring_offsets[row + 1] - encoding.ring_offsets[row]; };
    const auto each_in_ring = [&](Index row, const auto& action) {
        if (valence(row) > kMostNeighbours) return;
        std::for_each(encoding.ring.begin() + encoding.ring_offsets[row],
                      encoding.ring.begin() + encoding.ring_offsets[row + 1], action);
    };
    // The rows that each vertex is in the ring of.
    const auto uses = grouped<Index>(count, [&](const auto& visit) {
        for (Index row = 0; row < count; ++row)
            each_in_ring(row, [&](Index v) { visit(v, row); });
    });

    Graph graph;
    graph.offsets.reserve(count + 1);
    std::vector<Index> seen_by(count, -1);
    WorkMeter work(execution);
    for (Index v = 0; v < count; ++v) {
        seen_by[v] = v;
        const auto note = [&](Index u) {
            if (seen_by[u] == v) return;
            seen_by[u] = v;
            graph.items.push_back(u);
        };
        const auto note_row = [&](Index row) {
            work.add(1 + valence(row));
            note(row);
            each_in_ring(row, note);
        };
        note_row(v);
        for (const Index row : uses.of(v))
            note_row(row);
        graph.offsets.push_back(static_cast<std::int64_t>(graph.items.size()));
    }
    return graph;
}

}  // namespace

std::vector<Index> find_elimination_order(const Encoding& encoding, int threads, const Execution& execution) {
    return nested_dissection(graph_of_rows(encoding, execution), threads, execution);
}

std::vector<Index> numbers_in_order(const std::vector<Index>& order, const Unknowns& unknowns) {
    std::vector<Index> numbers;
    numbers.reserve(unknowns.free.size());
    for (const Index v : order) {
        if (unknowns.number[v] >= 0) numbers.push_back(unknowns.number[v]);
    }
    return numbers;
}

}  // namespace meanvalue
