#include "meanvalue/linalg/dissection_tree.h"

#include <algorithm>
#include <utility>

namespace meanvalue {
namespace {

// Of a graph's vertices that lie in one part at least, for that to be taken as its whole, in percent.
constexpr std::size_t kNearlyAllPercent = 70;

}  // namespace

DissectionTree::DissectionTree(std::vector<Part> parts, Index size) : parts_(std::move(parts)) {
    parts_.push_back({0, size});
    const auto outer_first = [](const Part& a, const Part& b) {
        return a.begin != b.begin ? a.begin < b.begin : a.end > b.end;
    };
    std::sort(parts_.begin(), parts_.end(), outer_first);
    first_child_.assign(parts_.size(), -1);
    next_sibling_.assign(parts_.size(), -1);
    std::vector<Index> around;  // the parts that the current one is in, the innermost last
    for (Index part = 0; part < static_cast<Index>(parts_.size()); ++part) {
        while (!around.empty() && parts_[around.back()].end <= parts_[part].begin)
            around.pop_back();
        if (!around.empty()) next_sibling_[part] = std::exchange(first_child_[around.back()], part);
        around.push_back(part);
    }
}

DissectionTree DissectionTree::moved(const std::vector<Index>& places) const {
    DissectionTree result = *this;
    for (Part& part : result.parts_)
        part = {places[part.begin], places[part.end]};
    return result;
}

Separation DissectionTree::separate(const Graph& graph, const std::vector<Index>& places) const {
    std::vector<Index> sorted = places;
    std::sort(sorted.begin(), sorted.end());
    const auto count_in = [&](Index part) {
        const auto begin = std::lower_bound(sorted.begin(), sorted.end(), parts_[part].begin);
        return static_cast<std::size_t>(std::lower_bound(begin, sorted.end(), parts_[part].end) - begin);
    };
    struct Child {
        std::size_t count;
        Index part;
    };
    std::vector<Child> children;
    Index whole = 0;
    do {
        children.clear();
        for (Index child = first_child_[whole]; child >= 0; child = next_sibling_[child])
            children.push_back({count_in(child), child});
        std::sort(children.begin(), children.end(), [](const Child& a, const Child& b) {
            return a.count != b.count ? a.count > b.count : a.part < b.part;
        });
        if (!children.empty()) whole = children.front().part;
    } while (!children.empty() && children.front().count * 100 >= kNearlyAllPercent * sorted.size());

    // The larger ones first, each to the side that has less.
    std::size_t count_of[2] = {};
    std::vector<std::pair<Part, Side>> sides;
    for (const Child& child : children) {
        const Side side = count_of[kLeft] <= count_of[kRight] ? kLeft : kRight;
        count_of[side] += child.count;
        sides.emplace_back(parts_[child.part], side);
    }
    std::sort(sides.begin(), sides.end(), [](const auto& a, const auto& b) { return a.first.begin < b.first.begin; });
    Separation separation;
    separation.side.assign(graph.size(), kSeparator);
    separation.weight[kSeparator] = graph.total_weight();
    for (Index v = 0; v < graph.size(); ++v) {
        const auto behind = std::upper_bound(sides.begin(), sides.end(), places[v],
                                             [](Index place, const auto& of) { return place < of.first.begin; });
        if (behind == sides.begin() || places[v] >= std::prev(behind)->first.end) continue;
        separation.assign(graph, v, std::prev(behind)->second);
    }
    for (Index v = 0; v < graph.size(); ++v) {
        if (separation.side[v] != kLeft) continue;
        const bool touches =
            std::any_of(graph.begin(v), graph.end(v), [&](Index u) { return separation.side[u] == kRight; });
        if (touches) separation.assign(graph, v, kSeparator);
    }
    return separation;
}

}  // namespace meanvalue
