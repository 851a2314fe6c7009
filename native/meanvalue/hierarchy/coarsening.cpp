#include "meanvalue/hierarchy/coarsening.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "meanvalue/common/parallel.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/encoding/ring_encoder.h"

namespace meanvalue {
namespace {

// Classes of costs: the exponent of a double and the first two of its digits, so they are 19 % wide.
constexpr int kClassShift = 50;
constexpr std::size_t kClassCount = std::size_t{1} << (63 - kClassShift);

/// Positive numbers are ordered as their bits are, so that the leading bits are a class.
std::int32_t class_of(double cost) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &cost, sizeof(bits));
    return static_cast<std::int32_t>(bits >> kClassShift);
}

/// Numbers without order, a different one for each vertex (the last steps of MurmurHash3; Appleby). With the
/// vertices' own numbers a row of neighbors would take a round for each of them.
std::uint32_t shuffled(Index vertex) {
    auto number = static_cast<std::uint32_t>(vertex);
    number = (number ^ (number >> 16)) * 0x85ebca6bU;
    number = (number ^ (number >> 13)) * 0xc2b2ae35U;
    return number ^ (number >> 16);
}

void append(std::vector<Index>& list, const std::vector<Index>& more) {
    list.insert(list.end(), more.begin(), more.end());
}

}  // namespace

Coarsening::Coarsening(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                       const CoarseningOptions& options, int threads, const Execution& execution)
    : mesh_(rings, execution),
      positions_(positions),
      is_fixed_(is_fixed),
      rules_(find_removal_rules(rings, positions, is_fixed, options)),
      threads_(threads),
      execution_(execution),
      unit_(cost_unit(rings, positions)),
      states_(is_fixed.size()),
      claims_(is_fixed.size()),
      waiting_(kClassCount),
      recorder_(rings.vertex_count()) {
    for (auto& claim : claims_)
        claim.store(std::numeric_limits<std::uint64_t>::max(), std::memory_order_relaxed);
    remaining_ = static_cast<Index>(std::count(is_fixed.begin(), is_fixed.end(), 0));
    Vertices all(is_fixed.size());
    std::iota(all.begin(), all.end(), 0);
    look_at(all, -1);
}

void Coarsening::coarsen_to(Index count, Vertices& order) {
    while (remaining_ > count && lowest_ < kClassCount) {
        if (waiting_[lowest_].empty()) {
            ++lowest_;
            continue;
        }
        Vertices list;
        list.swap(waiting_[lowest_]);
        list = look_at(list, static_cast<std::int32_t>(lowest_));
        auto [chosen, others] = choose(list);
        append(waiting_[lowest_], others);
        Index most = remaining_ - count;
        const auto end =
            std::find_if(chosen.begin(), chosen.end(), [&](Index v) { return !is_fixed_[v] && most-- == 0; });
        for (auto late = end; late != chosen.end(); ++late) {
            states_[*late].waits = true;
            waiting_[lowest_].push_back(*late);
        }
        chosen.erase(end, chosen.end());
        remove(chosen, order);
    }
}

template <typename Visit>
Coarsening::Sorted Coarsening::sort_out(const Vertices& vertices, const Visit& visit) const {
    const auto count = static_cast<Index>(vertices.size());
    std::vector<Sorted> pieces(piece_count(count));
    parallel_pieces(count, threads_, execution_, [&](Index piece, Index begin, Index end) {
        Tools tools{CollapseCost(positions_, unit_), RingEncoder(positions_)};
        for (Index k = begin; k < end; ++k) {
            fetch_ahead(vertices, k, end);
            visit(vertices[k], tools, pieces[piece]);
        }
    });
    Sorted all;
    for (const Sorted& piece : pieces) {
        append(all.first, piece.first);
        append(all.others, piece.others);
    }
    return all;
}

/// What is known around the vertices that come after number k and before `end`. A round sweeps over the whole mesh:
/// without it, a third of the time at a million vertices is waiting for memory.
void Coarsening::fetch_ahead(const Vertices& vertices, Index k, Index end) const {
    constexpr Index kHead = 24;
    constexpr Index kRing = 16;
    constexpr Index kNeighbours = 8;
    if (k + kHead >= end) return;
    __builtin_prefetch(&states_[vertices[k + kHead]]);
    mesh_.fetch_head(vertices[k + kHead]);
    mesh_.fetch_ring(vertices[k + kRing]);
    for (const Index neighbour : mesh_.ring(vertices[k + kNeighbours])) {
        __builtin_prefetch(positions_.data() + neighbour * positions_.outerStride());
        __builtin_prefetch(&claims_[neighbour]);
        __builtin_prefetch(&states_[neighbour]);
        mesh_.fetch_head(neighbour);
    }
}

/// Finds the cheapest collapse of those that it is not known of, and lets them wait in its class. Those of up to
/// `cost_class` are returned instead, and claim their rings.
Coarsening::Vertices Coarsening::look_at(const Vertices& vertices, std::int32_t cost_class) {
    ++round_;
    Sorted found = sort_out(vertices, [&](Index vertex, Tools& tools, Sorted& sorted) {
        State& state = states_[vertex];
        if (!state.is_fresh) {
            state.is_fresh = true;
            state.waits = false;
            if (!mesh_.is_manifold(vertex) || rules_.stays[vertex] || is_hub(vertex)) return;
            tools.cost.set_vertex(vertex, mesh_.ring(vertex));
            const Collapse cheapest = tools.cost.cheapest([&](Index to) { return rules_.may_become(vertex, to); });
            if (cheapest.to < 0) return;
            state = {class_of(cheapest.cost), cheapest.to, true, true};
        }
        if (state.cost_class > cost_class) {
            sorted.others.push_back(vertex);
        } else {
            claim(vertex);
            sorted.first.push_back(vertex);
        }
    });
    for (const Index vertex : found.others)
        waiting_[states_[vertex].cost_class].push_back(vertex);
    return std::move(found.first);
}

/// Lower than all claims of earlier rounds.
std::uint64_t Coarsening::claim_of(Index vertex) const {
    return std::uint64_t{~round_} << 32 | shuffled(vertex);
}

void Coarsening::claim(Index vertex) {
    const std::uint64_t wanted = claim_of(vertex);
    const auto claim_one = [&](Index v) {
        if (is_hub(v)) return;
        std::uint64_t found = claims_[v].load(std::memory_order_relaxed);
        while (wanted < found && !claims_[v].compare_exchange_weak(found, wanted, std::memory_order_relaxed)) {
        }
    };
    claim_one(vertex);
    for (const Index neighbour : mesh_.ring(vertex))
        claim_one(neighbour);
}

bool Coarsening::has_its_ring(Index vertex) const {
    const std::uint64_t wanted = claim_of(vertex);
    const auto has = [&](Index v) { return is_hub(v) || claims_[v].load(std::memory_order_relaxed) == wanted; };
    const RingView ring = mesh_.ring(vertex);
    return has(vertex) && std::all_of(ring.begin(), ring.end(), has);
}

/// Whether the vertex can be put back by equation 7 and 13 without amplifying errors.
bool Coarsening::has_good_stencil(Index vertex, RingEncoder& encoder) const {
    const RingView ring = mesh_.ring(vertex);
    if (!spans_a_plane(positions_, ring.vertices, ring.valence)) return false;
    return (encoder.encode(vertex, ring.vertices, ring.valence) & ~kOnRingEdge) == 0;
}

/// What the vertex is merged into, by its cheapest legal collapse; or -1 where it has none for now.
/// @pre its state is fresh.
Index Coarsening::destination(Index vertex, Tools& tools) const {
    // A fixed vertex is never put back, so it needs no stencil.
    if (!is_fixed_[vertex] && !has_good_stencil(vertex, tools.encoder)) return -1;
    const Index to = states_[vertex].to;
    if (mesh_.can_collapse(vertex, to)) return to;
    tools.cost.set_vertex(vertex, mesh_.ring(vertex));
    const auto is_legal = [&](Index target) {
        return rules_.may_become(vertex, target) && mesh_.can_collapse(vertex, target);
    };
    return tools.cost.cheapest(is_legal).to;
}

/// Of the vertices those that have their rings and a collapse, and those that have not their rings.
Coarsening::Sorted Coarsening::choose(const Vertices& vertices) {
    return sort_out(vertices, [&](Index vertex, Tools& tools, Sorted& sorted) {
        if (!has_its_ring(vertex)) {
            sorted.others.push_back(vertex);
            return;
        }
        State& state = states_[vertex];
        state.waits = false;
        state.to = destination(vertex, tools);
        if (state.to >= 0) sorted.first.push_back(vertex);
    });
}

void Coarsening::remove(const Vertices& chosen, Vertices& order) {
    append(order, chosen);
    for (const Index vertex : chosen) {
        if (is_fixed_[vertex]) continue;
        recorder_.add(vertex, mesh_.ring(vertex));
        --remaining_;
        if (rules_.part[vertex] >= 0) soft_merges_.push_back({vertex, states_[vertex].to});
    }
    const auto remove_one = [&](Index vertex, Vertices& woken) {
        for (const Index neighbour : mesh_.ring(vertex)) {
            State& state = states_[neighbour];
            state.is_fresh = false;
            if (!state.waits) woken.push_back(neighbour);
            state.waits = true;
        }
        mesh_.collapse(vertex, states_[vertex].to);
    };
    const auto [woken, at_hubs] = sort_out(chosen, [&](Index vertex, Tools&, Sorted& sorted) {
        const RingView ring = mesh_.ring(vertex);
        if (std::any_of(ring.begin(), ring.end(), [&](Index v) { return is_hub(v); })) {
            sorted.others.push_back(vertex);
        } else {
            remove_one(vertex, sorted.first);
        }
    });
    append(waiting_[lowest_], woken);
    for (const Index vertex : at_hubs)
        remove_one(vertex, waiting_[lowest_]);
}

Hierarchy build_hierarchy(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                          const CoarseningOptions& options, int threads, Execution& execution) {
    execution.begin_stage("build hierarchy");
    Hierarchy result;
    Coarsening coarsening(rings, positions, is_fixed, options, threads, execution);
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
