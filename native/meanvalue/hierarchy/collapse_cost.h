// What removing a vertex by a half-edge collapse costs the shape: paper, section 3.1.
#pragma once

#include <limits>
#include <vector>

#include "meanvalue/common/tolerances.h"
#include "meanvalue/common/types.h"
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

}  // namespace meanvalue
