// The removal of vertices, in rounds of such that do not touch each other.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/ring_encoder.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {

/// A collapse of some vertex.
struct Collapse {
    double cost;
    Index to;  ///< the ring vertex that it is merged into, or -1
};

/// The cost of merging a vertex into one of its ring, lower is better; docs/algorithm.md, "Collapse cost". The paper
/// names its parts, volume preservation (Lindstrom and Turk) and minimal-angle maximization, and gives no formula.
///
/// Works on one vertex after another: what all of its collapses have in common is computed once. One instance for
/// each thread.
class CollapseCost {
  public:
    /// @param positions n x 3; must outlive this. @param unit the unit of costs, a volume: with cost_unit() they
    /// are the same numbers at any scale.
    CollapseCost(const PositionsView& positions, double unit) : positions_(positions), per_unit_(1.0 / unit) {}

    /// The vertex whose collapses are to be compared. Linear in the valence.
    void set_vertex(Index vertex, const RingView& ring);

    /// The cost of merging the vertex into ring vertex number `place`; linear in the valence.
    /// @param limit where the cost is at least this, any value from it up may be returned, sooner.
    double of(Index place, double limit) const;

    /// The cheapest collapse into a ring vertex for which allowed(its vertex number) holds, the first among equals;
    /// one that leads nowhere where there is none.
    template <typename Allowed>
    Collapse cheapest(const Allowed& allowed) const;

  private:
    /// A triangle at the vertex, relative to it.
    struct Corner {
        Vector3 ring_vertex;
        Vector3 edge;  // to the next ring vertex
        Vector3 area;  // of the triangle, doubled
        double squared_edge;
        double squared_area;
    };

    const PositionsView& positions_;
    double per_unit_;
    RingView ring_{};
    std::vector<Corner> corners_;
    mutable std::vector<double> squared_distance_;  // of the ring vertices from the one that is merged into
};

template <typename Allowed>
Collapse CollapseCost::cheapest(const Allowed& allowed) const {
    Collapse best{std::numeric_limits<double>::infinity(), -1};
    for (Index place = 0; place < ring_.valence; ++place) {
        const Index to = ring_.vertices[place];
        if (!allowed(to)) continue;
        const double cost = of(place, best.cost);
        // Nearer ones are equal, as across the mirror plane of a symmetric model.
        if (cost < (1.0 - kNegligible) * best.cost) best = {cost, to};
    }
    return best;
}

/// The cube of the root mean square of all edges, or 1 where that is 0.
double cost_unit(const OneRings& rings, const PositionsView& positions);

/// Fixed vertices hang together in parts, neighbors of one handle, and so do soft ones apart from them.
struct RemovalRules {
    std::vector<Index> part;  ///< n: number of the part; -1 for free vertices, and for fixed ones that all stay
    std::vector<char> stays;  ///< n: is never removed

    /// A vertex of a part may only be merged into its own part, or the part would shrink away under free ones.
    bool may_become(Index vertex, Index to) const { return part[vertex] < 0 || part[vertex] == part[to]; }
};

/// Up to four extreme vertices of each part stay: the farthest from its middle, the farthest from that, the farthest
/// from the line through both, and the farthest from those three. So a part keeps its extent, a part of up to four
/// vertices all of them, and one that is not on a line determines rotations as before.
/// Cost: linear.
RemovalRules find_removal_rules(const OneRings& rings, const PositionsView& positions,
                                const std::vector<char>& is_fixed, const CoarseningOptions& options);

/// Removes vertices and writes down what each removal needs to be undone.
///
/// Vertices wait in classes by what they cost. A round looks at those in the lowest class and removes all that have
/// their rings for themselves: every vertex claims its ring, and of several that claim the same vertex the first in
/// a fixed shuffled order has it. So the removals of a round touch different rings, and all threads make them at
/// once, with the same result for any number of them (independent sets: Luby 1986). Nobody claims a hub, or one
/// vertex around it could be removed in a round; removals that touch one are made one after another.
///
/// Costs mostly rise as the mesh gets coarser. How far is found out when the class that a vertex was in comes.
class Coarsening {
  public:
    /// @pre all that it is made with outlives it.
    Coarsening(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
               const CoarseningOptions& options, int threads, const Execution& execution);
    Coarsening(const Coarsening&) = delete;  // members refer to others
    Coarsening& operator=(const Coarsening&) = delete;

    /// Removes vertices until `count` free ones are left, or none can be removed.
    void coarsen_to(Index count, std::vector<Index>& order);

    Index remaining() const { return remaining_; }  ///< free vertices
    OneRings present_rings() const { return mesh_.present_rings(execution_); }
    Splits take_splits() { return recorder_.take(execution_); }
    const std::vector<SoftMerge>& soft_merges() const { return soft_merges_; }

  private:
    struct State {
        std::int32_t cost_class = 0;  // no collapse is of a lower one, but for what is new since
        Index to = -1;                // of the cheapest collapse
        bool is_fresh = false;        // else its ring has changed since
        bool waits = true;            // else it is not looked at again until its ring changes
    };
    using Vertices = std::vector<Index>;
    struct Sorted {
        Vertices first;
        Vertices others;
    };
    /// Scratch memory of one thread.
    struct Tools {
        CollapseCost cost;
        RingEncoder encoder;
    };

    void fetch_ahead(const Vertices& vertices, Index k, Index end) const;
    Vertices look_at(const Vertices& vertices, std::int32_t cost_class);
    /// It can have no collapse. Looking at longer rings, at each change of one, would be cubic in the valence; such a
    /// vertex is considered once its ring has shrunk.
    bool is_hub(Index vertex) const { return mesh_.ring(vertex).valence > RingMesh::kLongestRemovable; }
    void claim(Index vertex);
    bool has_its_ring(Index vertex) const;
    bool has_good_stencil(Index vertex, RingEncoder& encoder) const;
    Index destination(Index vertex, Tools& tools) const;
    Sorted choose(const Vertices& vertices);
    void remove(const Vertices& chosen, Vertices& order);
    std::uint64_t claim_of(Index vertex) const;
    /// Where visit(vertex, tools, sorted) puts each of the vertices, in their order.
    template <typename Visit>
    Sorted sort_out(const Vertices& vertices, const Visit& visit) const;

    RingMesh mesh_;
    const PositionsView& positions_;
    const std::vector<char>& is_fixed_;
    RemovalRules rules_;
    int threads_;
    const Execution& execution_;
    double unit_;  // of costs
    std::vector<State> states_;
    std::vector<std::atomic<std::uint64_t>> claims_;  // n: the lowest has the vertex
    std::uint32_t round_ = 0;
    std::vector<Vertices> waiting_;  // by class
    std::size_t lowest_ = 0;         // class in which any wait
    std::vector<SoftMerge> soft_merges_;
    SplitRecorder recorder_;
    Index remaining_ = 0;
};

}  // namespace meanvalue
