#include "meanvalue/optimise/elimination_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/linalg/nested_dissection.h"
#include "meanvalue/optimise/ring_room.h"

namespace meanvalue {
namespace {

/// Vertices that are in one row are neighbours. Rows that are too long to be solved for unless most of their vertices
/// are fixed are left out: any order is one for them.
Graph graph_of_rows(const Encoding& encoding, const Execution& execution) {
    const Index count = encoding.vertex_count();
    const auto valence = [&](Index row) { return encoding.ring_offsets[row + 1] - encoding.ring_offsets[row]; };
    const auto each_in_ring = [&](Index row, const auto& action) {
        if (valence(row) > RingRoom::kMostNeighbours) return;
        std::for_each(encoding.ring.begin() + encoding.ring_offsets[row],
                      encoding.ring.begin() + encoding.ring_offsets[row + 1], action);
    };
    std::vector<Index> use_start(count + 1, 0);  // the rows that a vertex is in the ring of
    for (Index row = 0; row < count; ++row)
        each_in_ring(row, [&](Index v) { ++use_start[v + 1]; });
    std::partial_sum(use_start.begin(), use_start.end(), use_start.begin());
    std::vector<Index> uses(use_start.back());
    std::vector<Index> next(use_start.begin(), use_start.end() - 1);
    for (Index row = 0; row < count; ++row)
        each_in_ring(row, [&](Index v) { uses[next[v]++] = row; });

    Graph graph;
    graph.weights.assign(count, 1);
    graph.offsets.reserve(count + 1);
    std::vector<Index> seen_by(count, -1);
    WorkMeter work(execution);
    for (Index v = 0; v < count; ++v) {
        const auto first = static_cast<std::ptrdiff_t>(graph.neighbours.size());
        seen_by[v] = v;
        const auto note = [&](Index u) {
            if (seen_by[u] == v) return;
            seen_by[u] = v;
            graph.neighbours.push_back(u);
        };
        const auto note_row = [&](Index row) {
            work.add(1 + valence(row));
            note(row);
            each_in_ring(row, note);
        };
        note_row(v);
        for (Index k = use_start[v]; k < use_start[v + 1]; ++k)
            note_row(uses[k]);
        std::sort(graph.neighbours.begin() + first, graph.neighbours.end());
        graph.offsets.push_back(static_cast<std::int64_t>(graph.neighbours.size()));
    }
    return graph;
}

}  // namespace

RegionOrder find_elimination_order(const Encoding& encoding, int threads, const Execution& execution) {
    Graph columns = graph_of_rows(encoding, execution);
    const VertexGroups groups = group_same_columns(columns, execution);
    const Graph graph = contracted_columns(std::move(columns), groups, execution);
    RegionOrder order;
    order.vertices.reserve(encoding.vertex_count());
    std::vector<Index> places;  // of each group in the order of vertices
    for (const Index group : nested_dissection(graph, threads, execution, &order.tree)) {
        places.push_back(static_cast<Index>(order.vertices.size()));
        order.vertices.insert(order.vertices.end(), groups.members.begin() + groups.offsets[group],
                              groups.members.begin() + groups.offsets[group + 1]);
    }
    places.push_back(static_cast<Index>(order.vertices.size()));
    order.tree = order.tree.moved(places);
    return order;
}

std::vector<Index> slots_in_order(const std::vector<Index>& order, const Unknowns& unknowns) {
    std::vector<Index> slots;
    slots.reserve(unknowns.free.size());
    for (const Index v : order) {
        if (unknowns.slot[v] >= 0) slots.push_back(unknowns.slot[v]);
    }
    return slots;
}

std::vector<Index> order_along(const RegionOrder& whole, const SparseMatrix& lower, const Unknowns& unknowns,
                               int threads, const Execution& execution) {
    if (whole.vertices.empty()) return {};  // the factor then finds one of its own
    std::vector<Index> places(unknowns.free.size());
    for (std::size_t k = 0; k < whole.vertices.size(); ++k) {
        const Index slot = unknowns.slot[whole.vertices[k]];
        if (slot >= 0) places[slot] = static_cast<Index>(k);
    }
    return nested_dissection_along(whole.tree, places, graph_of(lower, execution), threads, execution);
}

}  // namespace meanvalue
