#include "meanvalue/hierarchy/coarsening.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "meanvalue/common/parallel.h"

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
      rules_(mesh_, rings, positions, is_fixed, options),
      threads_(threads),
      execution_(execution),
      unit_(cost_unit(rings, positions)),
      states_(is_fixed.size()),
      claims_(is_fixed.size()),
      waiting_(kClassCount),
      recorder_(rings.vertex_count()) {
    for (auto& claim : claims_)
        claim.store(std::numeric_limits<std::uint64_t>::max(), std::memory_order_relaxed);
    for (const char fixed : is_fixed)
        remaining_ += fixed ? 0 : 1;
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
        Vertices chosen;
        choose(list, chosen, waiting_[lowest_]);
        Index most = remaining_ - count;
        const auto end =
            std::find_if(chosen.begin(), chosen.end(), [&](Index v) { return !rules_.is_fixed(v) && most-- == 0; });
        for (auto late = end; late != chosen.end(); ++late) {
            states_[*late].waits = true;
            waiting_[lowest_].push_back(*late);
        }
        chosen.erase(end, chosen.end());
        remove(chosen, order);
    }
}

template <typename Result, typename Body>
std::vector<Result> Coarsening::in_pieces(Index count, const Body& body) const {
    std::vector<Result> results(piece_count(count));
    const auto run = [&](Index piece, Index begin, Index end) { body(begin, end, results[piece]); };
    parallel_pieces(count, threads_, execution_, run);
    return results;
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
    struct Found {
        Vertices cheap;
        Vertices others;
    };
    ++round_;
    const auto found =
        in_pieces<Found>(static_cast<Index>(vertices.size()), [&](Index begin, Index end, Found& result) {
            CollapseCost cost(positions_, unit_);
            for (Index k = begin; k < end; ++k) {
                fetch_ahead(vertices, k, end);
                const Index vertex = vertices[k];
                State& state = states_[vertex];
                if (!state.is_fresh) {
                    state.is_fresh = true;
                    state.waits = false;
                    if (!rules_.is_removable(vertex) || !rules_.is_short(vertex)) continue;
                    const Collapse cheapest = rules_.cheapest(vertex, cost);
                    if (cheapest.to < 0) continue;
                    state = {class_of(cheapest.cost), cheapest.to, true, true};
                }
                if (state.cost_class > cost_class) {
                    result.others.push_back(vertex);
                } else {
                    claim(vertex);
                    result.cheap.push_back(vertex);
                }
            }
        });
    Vertices cheap;
    for (const Found& piece : found) {
        append(cheap, piece.cheap);
        for (const Index vertex : piece.others)
            waiting_[states_[vertex].cost_class].push_back(vertex);
    }
    return cheap;
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

/// What the vertex is merged into, by its cheapest legal collapse; or -1 where it has none for now.
/// @pre its state is fresh.
Index Coarsening::destination(Index vertex, CollapseCost& cost, RingEncoder& encoder) const {
    // A fixed vertex is never put back, so it needs no stencil.
    if (!rules_.is_fixed(vertex) && !rules_.has_good_stencil(vertex, encoder)) return -1;
    const Index to = states_[vertex].to;
    if (mesh_.can_collapse(vertex, to)) return to;
    cost.set_vertex(vertex, mesh_.ring(vertex));
    const auto is_legal = [&](Index target) {
        return rules_.may_become(vertex, target) && mesh_.can_collapse(vertex, target);
    };
    return cost.cheapest(is_legal).to;
}

/// Of the vertices those that have their rings and a collapse, and those that have not their rings.
void Coarsening::choose(const Vertices& vertices, Vertices& chosen, Vertices& others) {
    struct Found {
        Vertices chosen;
        Vertices others;
    };
    const auto found =
        in_pieces<Found>(static_cast<Index>(vertices.size()), [&](Index begin, Index end, Found& result) {
            CollapseCost cost(positions_, unit_);
            RingEncoder encoder(positions_);
            for (Index k = begin; k < end; ++k) {
                fetch_ahead(vertices, k, end);
                const Index vertex = vertices[k];
                if (!has_its_ring(vertex)) {
                    result.others.push_back(vertex);
                    continue;
                }
                State& state = states_[vertex];
                state.waits = false;
                state.to = destination(vertex, cost, encoder);
                if (state.to >= 0) result.chosen.push_back(vertex);
            }
        });
    for (const Found& piece : found) {
        append(chosen, piece.chosen);
        append(others, piece.others);
    }
}

void Coarsening::remove(const Vertices& chosen, Vertices& order) {
    append(order, chosen);
    for (const Index vertex : chosen) {
        if (!rules_.is_fixed(vertex)) {
            recorder_.add(vertex, mesh_.ring(vertex));
            --remaining_;
        }
        if (rules_.is_soft(vertex)) soft_merges_.push_back({vertex, states_[vertex].to});
    }
    struct Done {
        Vertices woken;
        Vertices at_hubs;  // not removed yet
    };
    const auto remove_one = [&](Index vertex, Vertices& woken) {
        for (const Index neighbour : mesh_.ring(vertex)) {
            State& state = states_[neighbour];
            state.is_fresh = false;
            if (!state.waits) woken.push_back(neighbour);
            state.waits = true;
        }
        mesh_.collapse(vertex, states_[vertex].to);
    };
    const auto done = in_pieces<Done>(static_cast<Index>(chosen.size()), [&](Index begin, Index end, Done& result) {
        for (Index k = begin; k < end; ++k) {
            fetch_ahead(chosen, k, end);
            const RingView ring = mesh_.ring(chosen[k]);
            if (std::any_of(ring.begin(), ring.end(), [&](Index v) { return is_hub(v); })) {
                result.at_hubs.push_back(chosen[k]);
            } else {
                remove_one(chosen[k], result.woken);
            }
        }
    });
    for (const Done& piece : done) {
        append(waiting_[lowest_], piece.woken);
        for (const Index vertex : piece.at_hubs)
            remove_one(vertex, waiting_[lowest_]);
    }
}

}  // namespace meanvalue
