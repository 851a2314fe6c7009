#include <algorithm>
#include <functional>
#include <limits>
#include <queue>

#include "meanvalue/common/parallel.h"
#include "meanvalue/hierarchy/collapse_cost.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/hierarchy/removal_rules.h"
#include "meanvalue/hierarchy/removal_turns.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {
namespace {

// What a round of the queue costs at least, besides long rings: see WorkMeter.
constexpr std::size_t kStepsPerRound = 128;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Removes one vertex after another and writes down what each removal needs to be undone.
///
/// The vertex at its turn is the one with the lowest Candidate of all that wait: those whose ring has changed since
/// they could not be removed, or that have not been at their turn. A candidate depends on the vertex' ring and on how
/// it is held, whether it can be removed on its ring and those of its neighbours. So where an earlier coarsening is
/// followed, a vertex does what it did then, at the same candidate, until its ring is another one than then: from
/// there on it is astray, and what it costs is computed. Two orders are merged: that of the log, and that of the
/// queue of what is astray.
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
          unit_(cost_unit(rings, positions, execution)),
          cost_(positions, unit_),
          states_(is_fixed.size()),
          recorder_(rings.vertex_count()) {
        if (earlier_ != nullptr) {
            const std::vector<char> held_otherwise = rules_.held_otherwise(*earlier_);
            for (std::size_t v = 0; v < states_.size(); ++v)
                states_[v].is_astray = held_otherwise[v] != 0;
        }
        std::vector<Candidate> candidates(is_fixed.size(), kNoClass << 32);
        parallel_for(rings.vertex_count(), threads, execution, [&](Index begin, Index end) {
            CollapseCost cost(positions_, unit_);
            for (Index v = begin; v < end; ++v) {
                if (states_[v].is_astray && may_go(v) && look_at(v, cost)) {
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
            work_.add(kStepsPerRound);
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
    bool is_removed(Index vertex) const { return states_[vertex].is_removed; }

    RemovalLog take_log() { return rules_.log_of(std::move(turns_)); }

  private:
    using Queue = std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>>;

    struct State {
        std::uint32_t cost_class = 0;  // no collapse is of a lower one
        Index to = -1;                 // of the cheapest collapse
        bool is_fresh = false;         // else the surroundings have changed since, and the cost may have risen
        bool waits = false;            // it is in the queue, by that class
        bool is_removed = false;
        bool is_astray = true;    // else it is where it was in the log, and the above is not known
        bool is_blocked = false;  // it could not be removed at its turn, and its ring is the same since
    };

    /// The candidate of the next turn in the log whose vertex is where it was then. What is there when others went is
    /// astray from there on, and everything at the end.
    Candidate next_logged() {
        if (earlier_ == nullptr) return kLastCandidate;
        for (; turn_ < earlier_->turns.size(); ++turn_) {
            const RemovalLog::Turn& turn = earlier_->turns[turn_];
            const State& state = states_[turn.vertex];
            if (!state.is_astray) return candidate(turn.cost_class, turn.vertex);
            if (turn.to >= 0 && !state.is_removed) lead_astray(turn.vertex);
        }
        for (Index v = 0; v < mesh_.vertex_count(); ++v) {
            execution_.check_every(v);
            go_astray(v);
        }
        earlier_ = nullptr;
        return kLastCandidate;
    }

    void go_astray(Index vertex) {
        State& state = states_[vertex];
        if (state.is_astray || state.is_removed) return;
        state.is_astray = true;
        if (!state.is_blocked && may_go(vertex) && look_at(vertex, cost_)) enqueue(vertex);
    }

    /// All neighbours of the vertex.
    void lead_astray(Index vertex) {
        for (const Index neighbour : mesh_.ring(vertex))
            go_astray(neighbour);
    }

    /// A turn of the log. Where no neighbour is astray, nothing that decides is another than then.
    void follow(const RemovalLog::Turn& turn, std::vector<Index>& order) {
        const RingView ring = mesh_.ring(turn.vertex);
        Index to = turn.to;
        if (std::any_of(ring.begin(), ring.end(), [&](Index v) { return states_[v].is_astray; })) {
            look_at(turn.vertex, cost_);
            to = destination(turn.vertex);
            if (to != turn.to) lead_astray(turn.vertex);
        }
        turns_.push_back({turn.cost_class, turn.vertex, to});
        if (to >= 0) {
            remove(turn.vertex, to, order);
            return;
        }
        states_[turn.vertex].is_blocked = true;
        if (to != turn.to) go_astray(turn.vertex);
    }

    /// @param logged what comes after it at the earliest.
    void take_first_of_queue(Candidate logged, std::vector<Index>& order) {
        const Candidate first = candidates_.top();
        candidates_.pop();
        const auto vertex = static_cast<Index>(first & 0xffffffff);
        const Candidate next = candidates_.empty() ? logged : std::min(logged, candidates_.top());
        if (!candidates_.empty()) {
            const auto next_vertex = static_cast<Index>(candidates_.top() & 0xffffffff);
            __builtin_prefetch(&states_[next_vertex]);
            mesh_.prefetch(next_vertex);
        }
        State& state = states_[vertex];
        if (!state.waits || first >> 32 != state.cost_class) return;  // it has a newer place in the queue
        state.waits = false;
        if (!state.is_fresh) {
            if (!look_at(vertex, cost_)) return;
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
    bool look_at(Index vertex, CollapseCost& cost) {
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
        cost_.look_at(vertex, ring);
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
        // What follows waits for memory more than it computes: all that it will read is asked for at once.
        for (const Index neighbour : neighbours_) {
            __builtin_prefetch(&states_[neighbour]);
            if (!rules_.is_short(neighbour)) continue;
            for (const Index second : mesh_.ring(neighbour))
                __builtin_prefetch(positions_.row(second).data());
        }
        if (rules_.is_soft(vertex)) soft_merges_.push_back({vertex, to});
        mesh_.collapse(vertex, to);
        states_[vertex].is_removed = true;
        for (const Index neighbour : neighbours_)
            ring_changed(neighbour, states_[vertex].is_astray);
    }

    /// @param goes_astray by what happened at another time, or not at all, in the log.
    void ring_changed(Index vertex, bool goes_astray) {
        State& state = states_[vertex];
        state.is_blocked = false;
        if (!state.is_astray) {
            if (goes_astray) go_astray(vertex);
            return;
        }
        if (!may_go(vertex)) return;
        if (!state.waits) {
            if (look_at(vertex, cost_)) enqueue(vertex);
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

RemovalOrder find_removal_order(const OneRings& rings, const PositionsView& positions,
                                const std::vector<char>& is_fixed, const CoarseningOptions& options, int threads,
                                Execution& execution, const RemovalLog* earlier,
                                std::shared_ptr<const RemovalLog>* log) {
    execution.begin_stage("build hierarchy");
    RemovalOrder result;
    Coarsening coarsening(rings, positions, is_fixed, options, threads, execution, earlier);
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
    if (log != nullptr) *log = std::make_shared<const RemovalLog>(coarsening.take_log());
    return result;
}

}  // namespace meanvalue
