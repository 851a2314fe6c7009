#include "meanvalue/linalg/separator_refinement.h"

#include <algorithm>
#include <limits>

namespace meanvalue {
namespace {

constexpr int kPasses = 8;
// A pass ends after as many moves in a row without a better state as the separator has vertices, within these limits.
constexpr std::size_t kLeastPatience = 10;
constexpr std::size_t kMostPatience = 60;

constexpr std::int64_t kNotQueued = std::numeric_limits<std::int64_t>::min();

constexpr Side opposite(int side) {
    return side == kLeft ? kRight : kLeft;
}

}  // namespace

std::array<std::int64_t, 3> Separation::rank(std::int64_t most) const {
    const std::int64_t heavier = std::max(weight[kLeft], weight[kRight]);
    return {std::max<std::int64_t>(heavier - most, 0), weight[kSeparator], heavier};
}

void SeparatorRefinement::refine(const Graph& graph, Separation& separation, std::int64_t most,
                                 const Execution& execution) {
    WorkMeter work(execution);
    const Index size = graph.size();
    separator_.clear();
    for (Index v = 0; v < size; ++v) {
        if (separation.side[v] == kSeparator) separator_.push_back(v);
    }
    across_[kLeft].resize(size);
    across_[kRight].resize(size);
    queued_[kLeft].resize(size);
    queued_[kRight].resize(size);
    moved_in_.assign(size, 0);
    for (pass_ = 1; pass_ <= kPasses; ++pass_) {
        if (!pass(graph, separation, most, work)) return;
    }
}

/// @return whether it has come to something better.
bool SeparatorRefinement::pass(const Graph& graph, Separation& separation, std::int64_t most, WorkMeter& work) {
    moves_.clear();
    pulled_.clear();
    heap_[kLeft].clear();
    heap_[kRight].clear();
    for (const Index v : separator_)
        start(graph, separation, v, work);
    const auto before = separation.rank(most);
    auto best = before;
    const std::size_t patience = std::clamp(separator_.size(), kLeastPatience, kMostPatience);
    std::size_t kept = 0;
    Index vertex = 0;
    Side to = kLeft;
    while (moves_.size() - kept < patience && choose(graph, separation, most, vertex, to)) {
        move(graph, separation, vertex, to, work);
        const auto now = separation.rank(most);
        if (now < best) {
            best = now;
            kept = moves_.size();
        }
    }
    separator_.insert(separator_.end(), pulled_.begin(), pulled_.end());
    while (moves_.size() > kept)
        undo(graph, separation);
    const auto outside = [&](Index v) { return separation.side[v] != kSeparator; };
    separator_.erase(std::remove_if(separator_.begin(), separator_.end(), outside), separator_.end());
    std::sort(separator_.begin(), separator_.end());
    separator_.erase(std::unique(separator_.begin(), separator_.end()), separator_.end());
    return best < before;
}

void SeparatorRefinement::start(const Graph& graph, const Separation& separation, Index vertex, WorkMeter& work) {
    work.add(graph.degree(vertex));
    std::array<std::int64_t, 3> weight = {};
    for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u)
        weight[separation.side[*u]] += graph.weights[*u];
    across_[kLeft][vertex] = weight[kRight];
    across_[kRight][vertex] = weight[kLeft];
    if (moved_in_[vertex] == pass_) return;
    queued_[kLeft][vertex] = queued_[kRight][vertex] = kNotQueued;
    push(graph, vertex, kLeft);
    push(graph, vertex, kRight);
}

void SeparatorRefinement::push(const Graph& graph, Index vertex, int to) {
    const std::int64_t value = gain(graph, vertex, to);
    if (value <= queued_[to][vertex]) return;  // found out when it comes to the top
    queued_[to][vertex] = value;
    heap_[to].emplace_back(value, -vertex);
    std::push_heap(heap_[to].begin(), heap_[to].end());
}

/// The best move there that is still possible. @return false where there is none.
bool SeparatorRefinement::top(const Graph& graph, const Separation& separation, int to, Entry& entry) {
    std::vector<Entry>& heap = heap_[to];
    while (!heap.empty()) {
        entry = heap.front();
        const Index vertex = -entry.second;
        const bool counts =
            entry.first == queued_[to][vertex] && separation.side[vertex] == kSeparator && moved_in_[vertex] != pass_;
        if (counts && gain(graph, vertex, to) == entry.first) return true;
        std::pop_heap(heap.begin(), heap.end());
        heap.pop_back();
        if (!counts) continue;
        queued_[to][vertex] = kNotQueued;
        push(graph, vertex, to);
    }
    return false;
}

bool SeparatorRefinement::choose(const Graph& graph, const Separation& separation, std::int64_t most, Index& vertex,
                                 Side& to) {
    bool found = false;
    std::array<std::int64_t, 2> best = {};
    for (const Side side : {kLeft, kRight}) {
        Entry entry;
        if (!top(graph, separation, side, entry)) continue;
        const std::int64_t after = separation.weight[side] + graph.weights[-entry.second];
        if (after > most && after > separation.weight[opposite(side)]) continue;
        const std::array<std::int64_t, 2> value = {entry.first, -after};
        if (found && value <= best) continue;
        found = true;
        best = value;
        vertex = -entry.second;
        to = side;
    }
    return found;
}

void SeparatorRefinement::move(const Graph& graph, Separation& separation, Index vertex, Side to, WorkMeter& work) {
    const Side from = opposite(to);
    separation.assign(graph, vertex, to);
    moved_in_[vertex] = pass_;
    const std::size_t first = pulled_.size();
    for (const Index* u = graph.begin(vertex); u != graph.end(vertex); ++u) {
        if (separation.side[*u] == kSeparator) {
            across_[from][*u] += graph.weights[vertex];  // worth less: found out when it comes to the top
        } else if (separation.side[*u] == from) {
            separation.assign(graph, *u, kSeparator);
            pulled_.push_back(*u);
            for (const Index* x = graph.begin(*u); x != graph.end(*u); ++x) {
                if (separation.side[*x] != kSeparator) continue;
                across_[to][*x] -= graph.weights[*u];
                if (moved_in_[*x] != pass_) push(graph, *x, to);
            }
            start(graph, separation, *u, work);
        }
    }
    work.add(static_cast<std::size_t>(graph.degree(vertex)) * (1 + pulled_.size() - first));
    moves_.push_back({vertex, to, static_cast<Index>(pulled_.size() - first)});
}

void SeparatorRefinement::undo(const Graph& graph, Separation& separation) {
    const Move last = moves_.back();
    moves_.pop_back();
    for (Index k = 0; k < last.pulled; ++k) {
        separation.assign(graph, pulled_.back(), opposite(last.to));
        pulled_.pop_back();
    }
    separation.assign(graph, last.vertex, kSeparator);
}

}  // namespace meanvalue
