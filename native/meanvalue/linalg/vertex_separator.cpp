#include "meanvalue/linalg/vertex_separator.h"

#include <algorithm>

namespace meanvalue {
namespace {

/// As many paths from left to right as there can be without a common vertex.
///
/// In the flow network each vertex is two nodes, its entry and its exit, with an arc of capacity 1 from the one to
/// the other; arcs from exits to the entries of neighbors are not limited. What is said of arcs is of the residual
/// network, in which arcs with flow lead back.
class DisjointPaths {
  public:
    DisjointPaths(const Graph& graph, Index left_end, Index right_begin, const Execution& execution)
        : graph_(graph),
          left_end_(left_end),
          right_begin_(right_begin),
          work_(execution),
          next_(graph.size(), -1),
          previous_(graph.size(), -1),
          is_reached_(2 * static_cast<std::size_t>(graph.size())),
          arc_(is_reached_.size()) {
        for (Index v = 0; v < left_end; ++v) {
            if (std::any_of(graph.begin(v), graph.end(v), [&](Index u) { return u >= left_end; }))
                starts_.push_back(v);
        }
    }

    void maximise() {
        bool is_longer = true;
        while (is_longer) {
            is_longer = false;
            std::fill(is_reached_.begin(), is_reached_.end(), 0);
            std::fill(arc_.begin(), arc_.end(), 0);
            for (const Index start : starts_) {
                if (next_[start] < 0 && augment(start)) is_longer = true;
            }
        }
    }

    /// @pre maximise(). What can still be reached is on the left, and what limits the flow is the separator.
    Side side(Index vertex) const {
        if (is_reached_[exit(vertex)] != 0) return Side::kLeft;
        const bool is_left = vertex < left_end_;
        if (is_reached_[entry(vertex)] != 0 || (is_left && next_[vertex] >= 0)) return Side::kBetween;
        return is_left ? Side::kLeft : Side::kRight;
    }

  private:
    static Index entry(Index vertex) { return 2 * vertex; }
    static Index exit(Index vertex) { return 2 * vertex + 1; }
    static bool is_exit(Index node) { return node % 2 == 1; }
    bool is_target(Index node) const { return !is_exit(node) && node / 2 >= right_begin_ && previous_[node / 2] < 0; }

    Index arc_count(Index node) const { return is_exit(node) ? graph_.degree(node / 2) + 1 : 1; }
    /// The node that an arc leads to, or -1 where it has no capacity left.
    Index head(Index node, Index arc) const {
        const Index v = node / 2;
        if (!is_exit(node)) return exit(previous_[v] < 0 ? v : previous_[v]);
        if (arc == graph_.degree(v)) return previous_[v] < 0 ? -1 : entry(v);
        const Index u = graph_.begin(v)[arc];
        return u < left_end_ || next_[v] == u ? -1 : entry(u);
    }

    /// Depth first, to nodes that were not reached in this round. @return whether a target was found.
    bool augment(Index start) {
        path_.assign(1, exit(start));
        is_reached_[exit(start)] = 1;
        while (!path_.empty()) {
            const Index node = path_.back();
            if (is_target(node)) {
                send_along_path();
                return true;
            }
            const Index count = arc_count(node);
            Index arc = arc_[node];
            Index to = -1;
            for (; arc < count && to < 0; ++arc) {
                to = head(node, arc);
                if (to >= 0 && is_reached_[to] != 0) to = -1;
            }
            work_.add(1 + arc - arc_[node]);
            arc_[node] = arc;
            if (to >= 0) {
                is_reached_[to] = 1;
                path_.push_back(to);
            } else {
                path_.pop_back();
            }
        }
        return false;
    }

    void send_along_path() {
        for (std::size_t k = 0; k + 1 < path_.size(); ++k) {
            const Index v = path_[k] / 2;
            const Index u = path_[k + 1] / 2;
            if (!is_exit(path_[k])) {
                if (u != v) next_[u] = -1;  // the path through u goes another way from there
            } else if (u == v) {
                previous_[v] = -1;
            } else {
                next_[v] = u;
                previous_[u] = v;
            }
        }
    }

    const Graph& graph_;
    Index left_end_;
    Index right_begin_;
    WorkMeter work_;
    std::vector<Index> starts_;     // vertices on the left with neighbors elsewhere
    std::vector<Index> next_;       // on the path through a vertex, or -1
    std::vector<Index> previous_;   // the same backwards
    std::vector<char> is_reached_;  // each node, in this round
    std::vector<Index> arc_;        // of each node: the first that was not tried yet
    std::vector<Index> path_;
};

}  // namespace

std::vector<Side> minimum_separator(const Graph& graph, Index left_end, Index right_begin,
                                    const Execution& execution) {
    DisjointPaths paths(graph, left_end, right_begin, execution);
    paths.maximise();
    std::vector<Side> sides(graph.size());
    for (Index v = 0; v < graph.size(); ++v)
        sides[v] = paths.side(v);
    return sides;
}

}  // namespace meanvalue
