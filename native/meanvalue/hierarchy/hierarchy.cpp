#include "meanvalue/hierarchy/hierarchy.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "meanvalue/hierarchy/removal_rules.h"
#include "meanvalue/hierarchy/removal_turns.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Removes one vertex after another and writes down what each removal needs to be undone.
///
/// The vertex at its turn is the one with the lowest Candidate of all that wait: those whose ring has changed since
/// they could not be removed, or that have not been at their turn. A candidate depends on the vertex' ring and on
/// whether it is fixed or soft, whether it can be removed on its ring and those of its neighbors. So where an
/// earlier coarsening is followed, a vertex does what it did then, at the same candidate, until its ring is another
/// one than then: from there on it deviates, and what it costs is computed. Two orders are merged: that of the log,
/// and that of the queue of what deviates.
class Coarsening {
  public:
    Coarsening(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
               const CoarseningOptions& options, int threads, const Execution& execution, const RemovalLog* earlier)
        : earlier_(earlier),
          mesh_(rings, execution),
          positions_(positions),
          rules_(mesh_, rings, positions, is_fixed, options),
          threads_(threads),
          execution_(execution),
          classes_(options.exact_order ? kFineBits : kCoarseBits),
          work_(execution),
          unit_(cost_unit(rings, positions)),
          cost_(positions, unit_),
          states_(is_fixed.size()),
          recorder_(rings.vertex_count()) {
        if (earlier_ != nullptr) {
            const std::vector<char> changed_since = rules_.changed_since(*earlier_);
            for (std::size_t v = 0; v < states_.size(); ++v)
                states_[v].deviates = changed_since[v] != 0;
        }
        std::vector<Candidate> candidates(is_fixed.size(), kNoClass << 32);
        parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
            CollapseCost cost(positions_, unit_);
            for (Index v = begin; v < end; ++v) {
                if (states_[v].deviates && may_go(v) && find_cheapest(v, cost)) {
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
        while (remaining_ > count) {
            work_.add(RingMesh::kLongestRing * RingMesh::kLongestRing);  // comparing costs at a ring
            const Candidate logged = next_logged();
            if (candidates_.empty() && logged == kLastCandidate) return;
            if (candidates_.empty() || logged < candidates_.top()) {
                follow(earlier_->turns[turn_++], order);
            } else {
                take_first_of_queue(logged, order);
            }
        }
    }

    Index remaining() const { return remaining_; }

    OneRings present_rings() const { return mesh_.present_rings(execution_); }
    Splits take_splits() { return recorder_.take(threads_, execution_); }
    const std::vector<SoftMerge>& soft_merges() const { return soft_merges_; }

    RemovalLog take_log() { return rules_.log_of(std::move(turns_)); }

  private:
    using Queue = std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>>;

    struct State {
        std::uint32_t cost_class = 0;  // no collapse is of a lower one
        Index to = -1;                 // of the cheapest collapse
        bool is_fresh = false;         // else the surroundings have changed since, and the cost may have risen
        bool waits = false;            // it is in the queue, by that class
        bool is_removed = false;
        bool deviates = true;     // else it is where it was in the log, and the above is not known
        bool is_blocked = false;  // it could not be removed at its turn, and its ring is the same since
    };

    /// The candidate of the next turn in the log whose vertex has not deviated. Where the vertex of a turn has, and
    /// was removed then but not now, its neighbors deviate from there on; at the end of the log all do.
    Candidate next_logged() {
        if (earlier_ == nullptr) return kLastCandidate;
        for (; turn_ < earlier_->turns.size(); ++turn_) {
            const RemovalLog::Turn& turn = earlier_->turns[turn_];
            const State& state = states_[turn.vertex];
            if (!state.deviates) return candidate(turn.cost_class, turn.vertex);
            if (turn.to >= 0 && !state.is_removed) neighbours_deviate(turn.vertex);
        }
        for (Index v = 0; v < mesh_.vertex_count(); ++v) {
            execution_.check_every(v);
            deviate(v);
        }
        earlier_ = nullptr;
        return kLastCandidate;
    }

    void deviate(Index vertex) {
        State& state = states_[vertex];
        if (state.deviates || state.is_removed) return;
        state.deviates = true;
        if (!state.is_blocked && may_go(vertex) && find_cheapest(vertex, cost_)) enqueue(vertex);
    }

    /// All neighbors of the vertex.
    void neighbours_deviate(Index vertex) {
        for (const Index neighbour : mesh_.ring(vertex))
            deviate(neighbour);
    }

    /// A turn of the log. Where no neighbour deviates, nothing that decides is another than then.
    void follow(const RemovalLog::Turn& turn, std::vector<Index>& order) {
        const RingView ring = mesh_.ring(turn.vertex);
        Index to = turn.to;
        if (std::any_of(ring.begin(), ring.end(), [&](Index v) { return states_[v].deviates; })) {
            find_cheapest(turn.vertex, cost_);
            to = destination(turn.vertex);
            if (to != turn.to) neighbours_deviate(turn.vertex);
        }
        turns_.push_back({turn.cost_class, turn.vertex, to});
        if (to >= 0) {
            remove(turn.vertex, to, order);
            return;
        }
        states_[turn.vertex].is_blocked = true;
        if (to != turn.to) deviate(turn.vertex);
    }

    /// @param logged what comes after it at the earliest.
    void take_first_of_queue(Candidate logged, std::vector<Index>& order) {
        const Candidate first = candidates_.top();
        candidates_.pop();
        const auto vertex = static_cast<Index>(first & 0xffffffff);
        const Candidate next = candidates_.empty() ? logged : std::min(logged, candidates_.top());
        State& state = states_[vertex];
        if (!state.waits || first >> 32 != state.cost_class) return;  // it has a newer place in the queue
        state.waits = false;
        if (!state.is_fresh) {
            if (!find_cheapest(vertex, cost_)) return;
            if (candidate(state.cost_class, vertex) > next) {
                enqueue(vertex);
                return;
            }
        }
        const Index to = destination(vertex);
        turns_.push_back({state.cost_class, vertex, to});
        if (to >= 0) remove(vertex, to, order);
    }

    bool may_go(Index vertex) const { return rules_.is_removable(vertex) && rules_.is_short(vertex); }

    /// @return whether it may be merged into anything.
    bool find_cheapest(Index vertex, CollapseCost& cost) {
        const Collapse found = rules_.cheapest(vertex, kUnlimited, cost);
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

    /// What the vertex is merged into, by its cheapest legal collapse; or -1 where it has none for now: it is
    /// considered again when its ring changes. @pre its state is fresh.
    Index destination(Index vertex) {
        const RingView ring = mesh_.ring(vertex);
        // Comparing rings and changing them is linear in their lengths.
        for (const Index neighbour : ring)
            work_.add(mesh_.ring(neighbour).valence);
        // A fixed vertex is never put back, so it needs no stencil.
        if (!rules_.is_fixed(vertex) && !rules_.has_good_stencil(vertex)) return -1;
        const Index to = states_[vertex].to;
        if (mesh_.can_collapse(vertex, to)) return to;
        cost_.set_vertex(vertex, ring);
        const auto is_legal = [&](Index target) {
            return rules_.may_become(vertex, target) && mesh_.can_collapse(vertex, target);
        };
        return cost_.cheapest(kUnlimited, is_legal).to;
    }

    void remove(Index vertex, Index to, std::vector<Index>& order) {
        const RingView ring = mesh_.ring(vertex);
        order.push_back(vertex);
        if (!rules_.is_fixed(vertex)) {
            recorder_.add(vertex, ring);
            --remaining_;
        }
        neighbours_.assign(ring.begin(), ring.end());
        if (rules_.is_soft(vertex)) soft_merges_.push_back({vertex, to});
        mesh_.collapse(vertex, to);
        states_[vertex].is_removed = true;
        for (const Index neighbour : neighbours_)
            ring_changed(neighbour, states_[vertex].deviates);
    }

    /// @param deviates by what happened at another time, or not at all, in the log.
    void ring_changed(Index vertex, bool deviates) {
        State& state = states_[vertex];
        state.is_blocked = false;
        if (!state.deviates) {
            if (deviates) deviate(vertex);
            return;
        }
        if (!may_go(vertex)) return;
        if (!state.waits) {
            if (find_cheapest(vertex, cost_)) enqueue(vertex);
            return;
        }
        // Costs mostly rise as the mesh gets coarser. How far is found out when its turn comes; only a fall, which is
        // quick to rule out, changes its place now.
        const Collapse cheaper = rules_.cheapest(vertex, classes_.lowest_cost(state.cost_class), cost_);
        state.is_fresh = cheaper.to >= 0;
        if (!state.is_fresh) return;
        set_best(vertex, cheaper);
        enqueue(vertex);
    }

    const RemovalLog* earlier_;  // nullptr once it was followed to its end
    std::size_t turn_ = 0;       // the next in it
    std::vector<RemovalLog::Turn> turns_;
    RingMesh mesh_;
    const PositionsView& positions_;
    RemovalRules rules_;
    int threads_;
    const Execution& execution_;
    CostClasses classes_;
    WorkMeter work_;
    double unit_;  // of costs
    CollapseCost cost_;
    std::vector<SoftMerge> soft_merges_;
    std::vector<State> states_;
    Queue candidates_;
    std::vector<Index> neighbours_;
    SplitRecorder recorder_;
    Index remaining_ = 0;
};

}  // namespace

Hierarchy build_hierarchy(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                          const CoarseningOptions& options, int threads, Execution& execution,
                          const RemovalLog* earlier, std::shared_ptr<const RemovalLog>* log) {
    execution.begin_stage("build hierarchy");
    Hierarchy result;
    Coarsening coarsening(rings, positions, is_fixed, options, threads, execution, earlier);
    std::vector<OneRings> level_rings;
    const auto add_level = [&](Index size) {
        coarsening.coarsen_to(size, result.order);
        level_rings.push_back(coarsening.present_rings());
        result.levels.push_back({result.order.size(), coarsening.remaining(), {}, coarsening.take_splits()});
    };
    for (const Index size : options.level_sizes)
        add_level(size);
    if (options.down_to_base || options.level_sizes.empty()) add_level(0);
    result.soft_merges = coarsening.soft_merges();
    if (log != nullptr) *log = std::make_shared<const RemovalLog>(coarsening.take_log());
    for (std::size_t k = 0; k < level_rings.size(); ++k)
        result.levels[k].encoding = encode(level_rings[k], positions, threads, execution);
    return result;
}

Index Hierarchy::longest_ring() const {
    Index longest = 0;
    for (const Level& level : levels)
        longest = std::max({longest, level.encoding.longest_ring(), level.splits.longest_ring()});
    return longest;
}

}  // namespace meanvalue
