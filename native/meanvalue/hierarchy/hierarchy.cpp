#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <queue>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/encoding/ring_extension.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "meanvalue/hierarchy/fixed_parts.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {
namespace {

// What a round of the queue costs at least, besides long rings: see WorkMeter.
constexpr std::size_t kStepsPerRound = 128;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Costs of a class count as equal; 2^kFineBits classes to a doubling are as good as none, 2^kCoarseBits are 19 %
// wide. The sign and the exponent of a double take the rest of the 32 bits that a class has.
constexpr int kFineBits = 20;
constexpr int kCoarseBits = 2;
constexpr std::uint64_t kNoClass = 0xffffffff;

/// Positive numbers are ordered as their bits are, so that the leading bits are a class.
class CostClasses {
  public:
    explicit CostClasses(int bits) : shift_(52 - bits) {}

    std::uint32_t of(double cost) const {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &cost, sizeof(bits));
        return static_cast<std::uint32_t>(bits >> shift_);
    }

    double lowest_cost(std::uint32_t cost_class) const {
        const std::uint64_t bits = std::uint64_t{cost_class} << shift_;
        double cost = 0.0;
        std::memcpy(&cost, &bits, sizeof(cost));
        return cost;
    }

  private:
    int shift_;
};

/// A place in the queue: first by class, then by vertex number. So the order is the same everywhere, and vertices of
/// a class are mostly visited in an order in which neighbours, and what is known of them, are near each other in
/// memory.
using Candidate = std::uint64_t;

Candidate candidate(std::uint64_t cost_class, Index vertex) {
    return cost_class << 32 | static_cast<std::uint32_t>(vertex);
}

/// Removes one vertex after another and writes down what each removal needs to be undone.
class Coarsening {
  public:
    Coarsening(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
               const CoarseningOptions& options, int threads, const Execution& execution)
        : mesh_(rings, execution),
          positions_(positions),
          is_fixed_(is_fixed),
          threads_(threads),
          execution_(execution),
          classes_(options.exact_order ? kFineBits : kCoarseBits),
          work_(execution),
          unit_(cost_unit(rings, positions, execution)),
          cost_(positions, unit_),
          encoder_(positions),
          states_(is_fixed.size()),
          recorder_(rings.vertex_count()) {
        if (options.thin_out_fixed) parts_ = find_fixed_parts(rings, positions, is_fixed, options.handles);
        if (!options.is_soft.empty())
            soft_parts_ = find_fixed_parts(rings, positions, options.is_soft, options.handles);
        std::vector<Candidate> candidates(is_fixed.size(), kNoClass << 32);
        parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
            CollapseCost cost(positions_, unit_);
            for (Index v = begin; v < end; ++v) {
                if (is_removable(v) && is_short(v) && look_at(v, cost)) {
                    states_[v].waits = true;
                    candidates[v] = candidate(states_[v].cost_class, v);
                }
            }
        });
        for (const char fixed : is_fixed)
            remaining_ += fixed ? 0 : 1;
        candidates.erase(std::remove(candidates.begin(), candidates.end(), kNoClass << 32), candidates.end());
        candidates_ = Queue({}, std::move(candidates));
    }

    /// Removes vertices until `count` free ones are left, or none can be removed.
    void coarsen_to(Index count, std::vector<Index>& order) {
        while (remaining_ > count && !candidates_.empty()) {
            work_.add(kStepsPerRound);
            const Candidate first = candidates_.top();
            candidates_.pop();
            const Index vertex = static_cast<Index>(first & 0xffffffff);
            if (!candidates_.empty()) {
                const Index next = static_cast<Index>(candidates_.top() & 0xffffffff);
                __builtin_prefetch(&states_[next]);
                mesh_.prefetch(next);
            }
            State& state = states_[vertex];
            if (!state.waits || first >> 32 != state.cost_class) continue;  // it has a newer place in the queue
            state.waits = false;
            if (!state.is_fresh) {
                if (!look_at(vertex, cost_)) continue;
                if (!candidates_.empty() && candidate(state.cost_class, vertex) > candidates_.top()) {
                    enqueue(vertex);
                    continue;
                }
            }
            if (remove(vertex)) order.push_back(vertex);
        }
    }

    Index remaining() const { return remaining_; }

    /// Rings of the mesh as it is, of all vertices that are left.
    OneRings present_rings() const {
        OneRings rings;
        rings.offsets.reserve(states_.size() + 1);
        rings.kinds.reserve(states_.size());
        rings.closed.reserve(states_.size());
        for (Index v = 0; v < mesh_.vertex_count(); ++v) {
            execution_.check_every(v);
            const RingView ring = mesh_.ring(v);
            rings.append(ring.begin(), ring.end(), mesh_.kind(v), ring.closed);
        }
        return rings;
    }

    Splits take_splits() { return recorder_.take(threads_, execution_); }
    const std::vector<SoftMerge>& soft_merges() const { return soft_merges_; }
    bool is_removed(Index vertex) const { return states_[vertex].is_removed; }

  private:
    using Queue = std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>>;

    struct State {
        std::uint32_t cost_class = 0;  // no collapse is of a lower one
        Index to = -1;                 // of the cheapest collapse
        bool is_fresh = false;         // else the surroundings have changed since, and the cost may have risen
        bool waits = false;            // it is in the queue, by that class
        bool is_removed = false;
    };

    bool is_removable(Index vertex) const {
        if (!mesh_.is_manifold(vertex)) return false;
        if (is_soft(vertex)) return !soft_parts_.is_extreme[vertex];
        return !is_fixed_[vertex] || (!parts_.part.empty() && !parts_.is_extreme[vertex]);
    }

    /// Whether it can have a collapse at all. Looking at longer rings, at each change of one, would be cubic in the
    /// valence; such a vertex is looked at once its ring has shrunk.
    bool is_short(Index vertex) const { return mesh_.ring(vertex).valence <= RingMesh::kLongestRemovable; }

    bool is_soft(Index vertex) const { return !soft_parts_.part.empty() && soft_parts_.part[vertex] >= 0; }

    /// A fixed vertex may only be merged into its own part, or the part would shrink away under free ones. The same
    /// holds for soft ones.
    bool may_become(Index vertex, Index to) const {
        if (is_soft(vertex)) return soft_parts_.part[vertex] == soft_parts_.part[to];
        return !is_fixed_[vertex] || parts_.part[vertex] == parts_.part[to];
    }

    /// The cheapest collapse below `limit`, or one of that cost that leads nowhere.
    Collapse cheapest(Index vertex, double limit, CollapseCost& cost) const {
        cost.look_at(vertex, mesh_.ring(vertex));
        return cost.cheapest(limit, [&](Index to) { return may_become(vertex, to); });
    }

    /// @return whether it may be merged into anything.
    bool look_at(Index vertex, CollapseCost& cost) {
        const Collapse found = cheapest(vertex, kUnlimited, cost);
        set_best(vertex, found);
        return found.to >= 0;
    }

    void set_best(Index vertex, const Collapse& found) {
        State& state = states_[vertex];
        state.cost_class = classes_.of(found.cost);
        state.to = found.to;
        state.is_fresh = true;
    }

    void enqueue(Index vertex) {
        states_[vertex].waits = true;
        candidates_.push(candidate(states_[vertex].cost_class, vertex));
    }

    /// Removes the vertex by its cheapest legal collapse. @return false where it has none for now; it is considered
    /// again when its surroundings change.
    bool remove(Index vertex) {
        const RingView ring = mesh_.ring(vertex);
        // Comparing rings and changing them is linear in their lengths.
        for (const Index neighbour : ring)
            work_.add(mesh_.ring(neighbour).valence);
        // A fixed vertex is never put back, so it needs no stencil.
        if (!is_fixed_[vertex] && !has_good_stencil(vertex, ring)) return false;
        Index to = states_[vertex].to;
        if (!mesh_.can_collapse(vertex, to)) {
            cost_.look_at(vertex, ring);
            to = cost_
                     .cheapest(kUnlimited,
                               [&](Index target) {
                                   return may_become(vertex, target) && mesh_.can_collapse(vertex, target);
                               })
                     .to;
            if (to < 0) return false;
        }
        if (!is_fixed_[vertex]) {
            recorder_.add(vertex, ring);
            --remaining_;
        }
        neighbours_.assign(ring.begin(), ring.end());
        // What follows waits for memory more than it computes: all that it will read is asked for at once.
        for (const Index neighbour : neighbours_) {
            __builtin_prefetch(&states_[neighbour]);
            if (!is_short(neighbour)) continue;
            for (const Index second : mesh_.ring(neighbour))
                __builtin_prefetch(positions_.row(second).data());
        }
        if (is_soft(vertex)) soft_merges_.push_back({vertex, to});
        mesh_.collapse(vertex, to);
        states_[vertex].is_removed = true;
        for (const Index neighbour : neighbours_)
            surroundings_changed(neighbour);
        return true;
    }

    void surroundings_changed(Index vertex) {
        if (!is_removable(vertex) || !is_short(vertex)) return;
        State& state = states_[vertex];
        if (!state.waits) {
            if (look_at(vertex, cost_)) enqueue(vertex);
            return;
        }
        // Costs mostly rise as the mesh gets coarser. How far is found out when its turn comes; only a fall, which is
        // quick to rule out, changes its place now.
        const Collapse cheaper = cheapest(vertex, classes_.lowest_cost(state.cost_class), cost_);
        state.is_fresh = cheaper.to >= 0;
        if (!state.is_fresh) return;
        set_best(vertex, cheaper);
        enqueue(vertex);
    }

    /// Whether the vertex can be put back by equation 7 and 13 without amplifying errors.
    bool has_good_stencil(Index vertex, const RingView& ring) {
        if (!spans_a_plane(positions_, ring.vertices, ring.valence)) return false;
        return (encoder_.encode(vertex, ring.vertices, ring.valence) & ~kOnRingEdge) == 0;
    }

    RingMesh mesh_;
    const PositionsView& positions_;
    const std::vector<char>& is_fixed_;
    int threads_;
    const Execution& execution_;
    CostClasses classes_;
    WorkMeter work_;
    double unit_;  // of costs
    CollapseCost cost_;
    RingEncoder encoder_;
    FixedParts parts_;       // empty where no fixed vertex may be removed
    FixedParts soft_parts_;  // the same of soft vertices; empty where there are none
    std::vector<SoftMerge> soft_merges_;
    std::vector<State> states_;
    Queue candidates_;
    std::vector<Index> neighbours_;
    SplitRecorder recorder_;
    Index remaining_ = 0;
};

}  // namespace

void Hierarchy::split(int coarse, int fine, Positions& positions, int threads, const Execution& execution) const {
    for (int level = coarse; level > fine; --level)
        levels[level].splits.apply(positions, threads, execution);
}

void Hierarchy::carry(int coarse, int fine, const PositionsView& rest, Positions& positions, int threads,
                      const Execution& execution) const {
    for (int level = coarse; level > fine; --level)
        levels[level].splits.carry(rest, positions, threads, execution);
}

Index Hierarchy::longest_ring() const {
    Index longest = 0;
    for (const Level& level : levels)
        longest = std::max({longest, level.encoding.longest_ring(), level.splits.longest_ring()});
    return longest;
}

std::size_t Hierarchy::bytes() const {
    std::size_t sum = order.capacity() * sizeof(Index) + soft_merges.capacity() * sizeof(SoftMerge);
    for (const Level& level : levels)
        sum += level.encoding.bytes() + level.splits.bytes();
    return sum;
}

RemovalOrder find_removal_order(const OneRings& rings, const PositionsView& positions,
                                const std::vector<char>& is_fixed, const CoarseningOptions& options, int threads,
                                Execution& execution) {
    execution.begin_stage("build hierarchy");
    RemovalOrder result;
    Coarsening coarsening(rings, positions, is_fixed, options, threads, execution);
    const auto add_level = [&](Index size) {
        coarsening.coarsen_to(size, result.order);
        result.levels.push_back(
            {result.order.size(), coarsening.remaining(), coarsening.present_rings(), coarsening.take_splits()});
    };
    for (const Index size : options.level_sizes)
        add_level(size);
    if (options.down_to_base || options.level_sizes.empty()) add_level(0);
    result.soft_merges = coarsening.soft_merges();
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        if (!is_fixed[v] && !coarsening.is_removed(v)) result.base_unknowns.push_back(v);
    }
    return result;
}

Hierarchy encode_along(RemovalOrder order, const PositionsView& positions, SplitBy split_by, int threads,
                       Execution& execution) {
    Hierarchy hierarchy;
    for (RemovalLevel& removal : order.levels) {
        Level level{removal.removed_count, removal.free_count, encode(removal.rings, positions, threads, execution),
                    std::move(removal.splits)};
        if (split_by == SplitBy::kEncoding) level.splits.encode(positions, threads, execution);
        hierarchy.levels.push_back(std::move(level));
    }
    hierarchy.order = std::move(order.order);
    hierarchy.soft_merges = std::move(order.soft_merges);
    hierarchy.base_unknowns = std::move(order.base_unknowns);
    return hierarchy;
}

}  // namespace meanvalue
