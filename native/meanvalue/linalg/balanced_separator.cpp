#include "meanvalue/linalg/balanced_separator.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <utility>

#include "meanvalue/common/grouped.h"

namespace meanvalue {
namespace {

// Shares of a graph, in percent. The first cut leaves as much on each side: less finds thinner places, and makes the
// larger side larger.
constexpr Index kLeastCut = 35;
// What exchanging leaves on each side.
constexpr Index kLeastLeft = 20;

Index share_of(Index size, Index percent) {
    return static_cast<Index>(std::int64_t{size} * percent / 100);
}

/// In edges, from one vertex.
std::vector<Index> distances(const Graph& graph, Index from, WorkMeter& work) {
    std::vector<Index> distance(graph.size(), -1);
    std::vector<Index> queue = {from};
    queue.reserve(graph.size());
    distance[from] = 0;
    for (std::size_t k = 0; k < queue.size(); ++k) {
        work.add(1 + graph.of(queue[k]).size());
        for (const Index u : graph.of(queue[k])) {
            if (distance[u] >= 0) continue;
            distance[u] = distance[queue[k]] + 1;
            queue.push_back(u);
        }
    }
    return distance;
}

/// From each of four vertices that are far from each other.
std::array<std::vector<Index>, 4> distances_from_extremes(const Graph& graph, WorkMeter& work) {
    std::array<std::vector<Index>, 4> result;
    std::vector<Index> nearest(graph.size(), graph.size());
    Index from = graph.size() - 1;
    for (std::vector<Index>& distance : result) {
        distance = distances(graph, from, work);
        for (Index v = 0; v < graph.size(); ++v)
            nearest[v] = std::min(nearest[v], distance[v]);
        from = static_cast<Index>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    }
    return result;
}

/// Vertices from one end of a graph to the other, cut in two.
struct Line {
    std::vector<Index> vertices;
    Index left_end = 0;
    std::int64_t cost = std::numeric_limits<std::int64_t>::max();
};

/// Cut where the fewest vertices before have neighbours behind, and both sides have about the same size.
/// @param heights n: at one end the lowest, at the other the highest.
Line cut_line(const Graph& graph, const std::vector<Index>& heights, WorkMeter& work) {
    const Index size = graph.size();
    const auto [lowest, highest] = std::minmax_element(heights.begin(), heights.end());
    Line line;
    line.vertices = grouped<Index>(*highest - *lowest + 1, [&, low = *lowest](const auto& visit) {
                        for (Index v = 0; v < size; ++v)
                            visit(heights[v] - low, v);
                    }).items;
    std::vector<Index> place(size);
    for (Index k = 0; k < size; ++k)
        place[line.vertices[k]] = k;
    const Index first = std::max(share_of(size, kLeastCut), 1);
    std::vector<Index> change(size + 1, 0);  // of the border, from one cut to the next
    for (Index k = 0; k < size - first; ++k) {
        const Index v = line.vertices[k];
        work.add(1 + graph.of(v).size());
        Index farthest = k;
        for (const Index u : graph.of(v))
            farthest = std::max(farthest, place[u]);
        ++change[k + 1];
        --change[farthest + 1];
    }
    std::int64_t border = 0;
    for (Index end = 0; end <= size - first; ++end) {
        border += change[end];
        const std::int64_t cost = border * (2 * size + std::abs(size - 2 * end + border));
        if (end < first || cost >= line.cost) continue;
        line.left_end = end;
        line.cost = cost;
    }
    return line;
}

/// The four extremes a, b, c, d are at the ends in one of the ways a | b, ac | bd, ad | bc.
Line best_line(const Graph& graph, WorkMeter& work) {
    constexpr Index kWays[3][4] = {{1, -1, 0, 0}, {1, -1, 1, -1}, {1, -1, -1, 1}};
    const std::array<std::vector<Index>, 4> distance = distances_from_extremes(graph, work);
    Line best;
    for (const auto& way : kWays) {
        std::vector<Index> heights(graph.size(), 0);
        for (std::size_t k = 0; k < distance.size(); ++k) {
            for (Index v = 0; v < graph.size(); ++v)
                heights[v] += way[k] * distance[k][v];
        }
        Line line = cut_line(graph, heights, work);
        if (line.cost < best.cost) best = std::move(line);
    }
    return best;
}

/// Vertices between two sides that are exchanged for fewer.
class Separator {
  public:
    Separator(const Graph& graph, const Line& line, WorkMeter& work)
        : graph_(graph), work_(work), sides_(graph.size(), Side::kLeft), via_(graph.size()) {
        for (auto v = line.vertices.begin() + line.left_end; v != line.vertices.end(); ++v)
            sides_[*v] = Side::kRight;
        for (Index v = 0; v < graph.size(); ++v) {
            const auto is_right = [&](Index u) { return sides_[u] == Side::kRight; };
            if (sides_[v] == Side::kLeft && std::any_of(graph.of(v).begin(), graph.of(v).end(), is_right))
                vertices_.push_back(v);
        }
        for (const Index v : vertices_)
            sides_[v] = Side::kBetween;
    }

    std::vector<Side> shrunk() {
        int failed = 0;
        for (Side to = Side::kRight; failed < 2; to = opposite(to))
            failed = shrink(to) ? 0 : failed + 1;
        return std::move(sides_);
    }

  private:
    static Side opposite(Side side) { return side == Side::kRight ? Side::kLeft : Side::kRight; }

    /// Exchanges some vertices for fewer neighbours on one side, the most that can be saved: what takes part in no
    /// largest matching (D. Koenig, Graphok es matrixok, Mat. Fiz. Lapok 38, 1931). @return whether it could.
    bool shrink(Side to) {
        match(to);
        std::vector<Index> next;
        for (const Index v : vertices_) {
            if (is_reached_[v] == 0) next.push_back(v);
        }
        const std::size_t kept = next.size();
        for (const Index v : vertices_) {
            for (const Index u : graph_.of(v)) {
                if (sides_[u] == to && std::exchange(is_reached_[u], 0) != 0) next.push_back(u);
            }
        }
        const auto left =
            std::count(sides_.begin(), sides_.end(), to) - static_cast<std::ptrdiff_t>(next.size() - kept);
        if (next.size() >= vertices_.size() || left < share_of(graph_.size(), kLeastLeft)) return false;
        for (const Index v : vertices_)
            sides_[v] = opposite(to);
        for (const Index v : next)
            sides_[v] = Side::kBetween;
        vertices_ = std::move(next);
        return true;
    }

    /// Pairs as many as can be with neighbours on one side. Then reached is what a chain of pairs leads to from one
    /// without a partner.
    void match(Side to) {
        partner_.assign(graph_.size(), -1);
        for (bool found = true; found;) {
            found = false;
            is_reached_.assign(graph_.size(), 0);
            for (const Index v : vertices_) {
                if (partner_[v] < 0 && find_partner(v, to)) found = true;
            }
        }
    }

    /// Breadth first, through what was not reached in this round.
    bool find_partner(Index vertex, Side to) {
        queue_.assign(1, vertex);
        is_reached_[vertex] = 1;
        for (std::size_t k = 0; k < queue_.size(); ++k) {
            const Index v = queue_[k];
            work_.add(1 + graph_.of(v).size());
            for (const Index u : graph_.of(v)) {
                if (sides_[u] != to || is_reached_[u] != 0) continue;
                is_reached_[u] = 1;
                via_[u] = v;
                if (partner_[u] < 0) {
                    for (Index free = u; free >= 0;) {
                        partner_[free] = via_[free];
                        free = std::exchange(partner_[via_[free]], free);
                    }
                    return true;
                }
                is_reached_[partner_[u]] = 1;
                queue_.push_back(partner_[u]);
            }
        }
        return false;
    }

    const Graph& graph_;
    WorkMeter& work_;
    std::vector<Side> sides_;
    std::vector<Index> vertices_;
    std::vector<Index> partner_;    // of each vertex, or -1
    std::vector<char> is_reached_;  // in this round
    std::vector<Index> via_;        // from which one of the separator a vertex was reached
    std::vector<Index> queue_;
};

}  // namespace

std::vector<Side> balanced_separator(const Graph& graph, const Execution& execution) {
    WorkMeter work(execution);
    return Separator(graph, best_line(graph, work), work).shrunk();
}

}  // namespace meanvalue
