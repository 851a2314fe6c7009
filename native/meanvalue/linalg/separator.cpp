#include "meanvalue/linalg/separator.h"

#include <algorithm>

namespace meanvalue {
namespace {

// Vertices below which a graph is coarse enough.
constexpr Index kCoarsest = 100;
// Members of a group at most.
constexpr Index kMembers = 4;
// Places where a side may begin, on the coarsest graph: more for large parts, on which most of the work depends, and
// of which there are few.
constexpr int kSeeds = 6;
constexpr int kSeedsOfLarge = 16;
constexpr std::int64_t kLarge = 4000;
// Of the whole that one side may have at most, in percent.
constexpr std::int64_t kMostPercent = 62;

// Of several separations those that go on to the next finer graph, in percent: which is the best is seen late.
constexpr std::size_t kKeptPercent = 60;

std::int64_t most_of(const Graph& graph) {
    return graph.total_weight() * kMostPercent / 100;
}

/// The neighbour in no group with which v has the most edges, the first of several; or -1.
Index nearest_free(const Graph& graph, Index v, const VertexGroups& groups, std::int64_t most_weight) {
    Index nearest = -1;
    Index edges = 0;
    for (std::int64_t k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
        const Index u = graph.neighbours[k];
        if (groups.group_of[u] >= 0 || graph.weights[u] > most_weight) continue;
        if (graph.edge_weights.empty()) return u;
        if (graph.edge_weights[k] <= edges) continue;
        edges = graph.edge_weights[k];
        nearest = u;
    }
    return nearest;
}

/// Each vertex, if it is in no group yet, with its nearest neighbours that are in none.
VertexGroups grouped(const Graph& graph, const Execution& execution) {
    const Index size = graph.size();
    VertexGroups groups;
    groups.group_of.assign(size, -1);
    groups.members.reserve(size);
    const std::int64_t heaviest = std::max<std::int64_t>(1, graph.total_weight() / 20);
    WorkMeter work(execution);
    for (Index v = 0; v < size; ++v) {
        work.add(1);
        if (groups.group_of[v] >= 0) continue;
        const Index group = groups.count();
        const auto first = static_cast<Index>(groups.members.size());
        std::int64_t weight = graph.weights[v];
        groups.group_of[v] = group;
        groups.members.push_back(v);
        work.add(graph.degree(v));
        while (static_cast<Index>(groups.members.size()) - first < kMembers) {
            const Index next = nearest_free(graph, v, groups, heaviest - weight);
            if (next < 0) break;
            weight += graph.weights[next];
            groups.group_of[next] = group;
            groups.members.push_back(next);
        }
        groups.offsets.push_back(static_cast<Index>(groups.members.size()));
    }
    return groups;
}

Separation projected(const Separation& coarse, const VertexGroups& groups) {
    Separation fine;
    fine.weight = coarse.weight;
    fine.side.resize(groups.group_of.size());
    for (std::size_t v = 0; v < fine.side.size(); ++v)
        fine.side[v] = coarse.side[groups.group_of[v]];
    return fine;
}

}  // namespace

/// Half of the graph, breadth first from a seed; what it borders on is the separator.
Separation SeparatorFinder::grow(const Graph& graph, Index seed, const Execution& execution) {
    Separation separation;
    separation.side.assign(graph.size(), kRight);
    separation.weight[kRight] = graph.total_weight();
    const std::int64_t half = separation.weight[kRight] / 2;
    WorkMeter work(execution);
    queue_.assign(1, seed);
    separation.assign(graph, seed, kSeparator);
    // What is in the queue is the separator.
    for (std::size_t k = 0; k < queue_.size() && separation.weight[kLeft] + separation.weight[kSeparator] / 2 < half;
         ++k) {
        const Index v = queue_[k];
        work.add(1 + graph.degree(v));
        separation.assign(graph, v, kLeft);
        for (const Index* u = graph.begin(v); u != graph.end(v); ++u) {
            if (separation.side[*u] != kRight) continue;
            separation.assign(graph, *u, kSeparator);
            queue_.push_back(*u);
        }
    }
    return separation;
}

std::vector<Separation> SeparatorFinder::find_on_coarsest(const Graph& graph, const Execution& execution) {
    std::vector<Separation> found;
    Index seed = 0;
    const int seeds = graph.total_weight() < kLarge ? kSeeds : kSeedsOfLarge;
    for (int attempt = 0; attempt < seeds; ++attempt) {
        found.push_back(grow(graph, seed, execution));
        // The next begins far from where this one began: what the search came to last, and vertices between.
        seed = attempt == 0 ? queue_.back() : static_cast<Index>(std::int64_t{graph.size()} * attempt / seeds);
    }
    return found;
}

/// Refines them, and leaves the better half.
void SeparatorFinder::refine_and_select(const Graph& graph, std::vector<Separation>& separations,
                                        const Execution& execution) {
    const std::int64_t most = most_of(graph);
    for (Separation& separation : separations)
        refinement_.refine(graph, separation, most, execution);
    std::stable_sort(separations.begin(), separations.end(),
                     [&](const Separation& a, const Separation& b) { return a.rank(most) < b.rank(most); });
    const auto same = [](const Separation& a, const Separation& b) { return a.weight == b.weight; };
    separations.erase(std::unique(separations.begin(), separations.end(), same), separations.end());
    separations.resize((separations.size() * kKeptPercent + 99) / 100);
}

Separation SeparatorFinder::find(const Graph& graph, const Execution& execution) {
    struct Level {
        VertexGroups groups;
        Graph coarse;
    };
    std::vector<Level> levels;
    const Graph* finest = &graph;
    while (finest->size() > kCoarsest) {
        Level level;
        level.groups = grouped(*finest, execution);
        if (level.groups.count() > finest->size() * 9 / 10) break;  // stars, say: their rays have one neighbour
        level.coarse = contracted(*finest, level.groups, execution);
        levels.push_back(std::move(level));
        finest = &levels.back().coarse;
    }
    std::vector<Separation> separations = find_on_coarsest(*finest, execution);
    refine_and_select(*finest, separations, execution);
    for (std::size_t k = levels.size(); k-- > 0;) {
        for (Separation& separation : separations)
            separation = projected(separation, levels[k].groups);
        refine_and_select(k == 0 ? graph : levels[k - 1].coarse, separations, execution);
    }
    return std::move(separations.front());
}

Separation SeparatorFinder::find_near(const Graph& graph, Separation start, const Execution& execution) {
    const std::int64_t most = most_of(graph);
    if (start.weight[kLeft] > 0 && start.weight[kRight] > 0) refinement_.refine(graph, start, most, execution);
    const bool is_good = start.weight[kLeft] > 0 && start.weight[kRight] > 0 && start.rank(most)[0] == 0;
    return is_good ? std::move(start) : find(graph, execution);
}

}  // namespace meanvalue
