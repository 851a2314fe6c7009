#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>
#include <queue>

#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/encoding/ring_extension.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {
namespace {

// Rings may not grow beyond this, or beyond what they were.
constexpr std::size_t kLongestRing = 16;

struct Candidate {
    double cost;
    Index vertex;
    Index version;  // of the vertex' surroundings when the cost was computed

    /// Ties go to the lower vertex number, so that the order is the same everywhere.
    bool operator<(const Candidate& other) const {
        return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
};

/// Removes one vertex after another and writes down what each removal needs to be undone.
class Coarsening {
  public:
    Coarsening(TriangleMesh& mesh, const PositionsView& positions, const std::vector<char>& removable,
               const Execution& execution)
        : mesh_(mesh),
          positions_(positions),
          removable_(removable),
          execution_(execution),
          encoder_(positions),
          version_(removable.size(), 0),
          removed_(removable.size(), 0),
          fans_of_removed_(removable.size()) {
        for (std::size_t v = 0; v < removable.size(); ++v) {
            execution_.check_every(v);
            if (removable[v]) {
                ++remaining_;
                consider(static_cast<Index>(v));
            }
        }
    }

    Index remaining() const { return remaining_; }

    /// Removes vertices until `count` removable ones are left. @return false where no legal collapse is left before.
    bool coarsen_to(Index count, std::vector<Index>& order) {
        while (remaining_ > count) {
            execution_.check_every(order.size());
            if (candidates_.empty()) return false;
            const Candidate candidate = candidates_.top();
            candidates_.pop();
            if (removed_[candidate.vertex] || candidate.version != version_[candidate.vertex]) continue;
            if (remove(candidate.vertex)) order.push_back(candidate.vertex);
        }
        return true;
    }

    /// Rings of the mesh as it is, of all vertices that are left.
    OneRings present_rings() const {
        OneRings rings;
        std::vector<Fan> fans;
        for (std::size_t v = 0; v < removed_.size(); ++v) {
            execution_.check_every(v);
            if (removed_[v]) {
                fans.clear();
            } else {
                mesh_.collect_fans(static_cast<Index>(v), fans);
            }
            rings.append(fans);
        }
        return rings;
    }

    /// Rings of the removed vertices at their removal; empty ones for the others.
    OneRings removal_rings() const {
        OneRings rings;
        std::vector<Fan> fans;
        for (const Fan& fan : fans_of_removed_) {
            fans.clear();
            if (!fan.ring.empty()) fans.push_back(fan);
            rings.append(fans);
        }
        return rings;
    }

  private:
    /// The only fan at a vertex, or nullptr where there are none or several.
    const Fan* fan_at(Index vertex) {
        mesh_.collect_fans(vertex, fans_);
        return fans_.size() == 1 ? &fans_.front() : nullptr;
    }

    /// Puts a vertex into the queue at the cost of its cheapest collapse.
    void consider(Index vertex) {
        const Fan* fan = fan_at(vertex);
        if (fan == nullptr) return;
        double cheapest = -1.0;
        for (const Index to : fan->ring) {
            const double cost = collapse_cost(positions_, vertex, to, *fan);
            if (cheapest < 0.0 || cost < cheapest) cheapest = cost;
        }
        candidates_.push({cheapest, vertex, version_[vertex]});
    }

    /// Removes the vertex by its cheapest legal collapse. @return false where it has none for now; it is considered
    /// again when its surroundings change.
    bool remove(Index vertex) {
        const Fan* found = fan_at(vertex);
        if (found == nullptr || !has_good_stencil(vertex, found->ring)) return false;
        const Fan fan = *found;
        const std::vector<Index>& ring = fan.ring;
        std::vector<std::pair<double, Index>> targets;
        targets.reserve(ring.size());
        for (const Index to : ring)
            targets.emplace_back(collapse_cost(positions_, vertex, to, fan), to);
        std::sort(targets.begin(), targets.end());
        for (const auto& [cost, to] : targets) {
            if (!mesh_.can_collapse(vertex, to) || ring_grows_too_long(ring.size(), to)) continue;
            mesh_.collapse(vertex, to);
            removed_[vertex] = 1;
            --remaining_;
            fans_of_removed_[vertex] = fan;
            for (const Index neighbour : ring) {
                ++version_[neighbour];
                if (removable_[neighbour]) consider(neighbour);
            }
            return true;
        }
        return false;
    }

    /// Whether the vertex can be put back by equation 7 and 13 without amplifying errors.
    bool has_good_stencil(Index vertex, const std::vector<Index>& ring) {
        if (!spans_a_plane(positions_, ring)) return false;
        const std::uint8_t flags = encoder_.encode(vertex, ring.data(), static_cast<Index>(ring.size()));
        return (flags & ~kOnRingEdge) == 0;
    }

    bool ring_grows_too_long(std::size_t removed_valence, Index to) {
        std::vector<Fan> fans;
        mesh_.collect_fans(to, fans);
        if (fans.size() != 1) return true;
        const std::size_t valence = fans.front().ring.size();
        const std::size_t merged = valence + removed_valence - std::min<std::size_t>(4, valence + removed_valence);
        return merged > std::max(kLongestRing, valence);
    }

    TriangleMesh& mesh_;
    const PositionsView& positions_;
    const std::vector<char>& removable_;
    const Execution& execution_;
    RingEncoder encoder_;
    std::vector<Index> version_;
    std::vector<char> removed_;
    std::vector<Fan> fans_of_removed_;
    std::priority_queue<Candidate> candidates_;
    std::vector<Fan> fans_;
    Index remaining_ = 0;
};

}  // namespace

Index Hierarchy::longest_ring() const {
    Index longest = splits.longest_ring();
    for (const Level& level : levels)
        longest = std::max(longest, level.encoding.longest_ring());
    return longest;
}

std::size_t Hierarchy::bytes() const {
    std::size_t sum = splits.bytes() + order.capacity() * sizeof(Index) + split_kinds.capacity() * sizeof(RingKind);
    for (const Level& level : levels)
        sum += level.encoding.bytes();
    return sum;
}

Hierarchy build_hierarchy(TriangleMesh& mesh, const PositionsView& positions, const std::vector<char>& removable,
                          const std::vector<Index>& level_sizes, int threads, Execution& execution) {
    execution.begin_stage("build hierarchy");
    Hierarchy hierarchy;
    Coarsening coarsening(mesh, positions, removable, execution);
    const auto keep_level = [&] {
        const OneRings rings = coarsening.present_rings();
        hierarchy.levels.push_back({hierarchy.order.size(), encode(rings, positions, threads, execution)});
    };
    for (const Index size : level_sizes) {
        if (!coarsening.coarsen_to(size, hierarchy.order)) break;
        keep_level();
    }
    coarsening.coarsen_to(0, hierarchy.order);
    keep_level();
    OneRings removal_rings = coarsening.removal_rings();
    hierarchy.splits = encode(removal_rings, positions, threads, execution);
    hierarchy.split_kinds = std::move(removal_rings.kinds);

    std::vector<char> is_gone(removable.size(), 0);
    for (const Index v : hierarchy.order)
        is_gone[v] = 1;
    for (std::size_t v = 0; v < removable.size(); ++v) {
        if (removable[v] && !is_gone[v]) hierarchy.base_unknowns.push_back(static_cast<Index>(v));
    }
    return hierarchy;
}

}  // namespace meanvalue
