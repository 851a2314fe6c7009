// The connectivity of a mesh that is being coarsened: nothing but rings, changed in place.
#pragma once

#include <cstddef>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/one_ring.h"

namespace meanvalue {

/// A view of one ring of a RingMesh; gone with the next collapse.
struct RingView {
    const Index* vertices;  ///< counter-clockwise seen from outside
    Index valence;
    bool closed;  ///< the triangles go all the way round

    const Index* begin() const { return vertices; }
    const Index* end() const { return vertices + valence; }
    /// How many triangles are at the vertex; number k has the corners k and k + 1 (cyclic).
    Index triangle_count() const { return closed ? valence : valence - 1; }
};

/// Rings under half-edge collapses. A ring of a usual mesh is one cache line, so that a collapse touches a handful
/// of them and allocates nothing.
class RingMesh {
  public:
    /// @param rings of the whole mesh. Non-manifold vertices, of which these know one fan, stay as they are.
    RingMesh(const OneRings& rings, const Execution& execution);

    Index vertex_count() const { return static_cast<Index>(heads_.size()); }
    RingView ring(Index vertex) const {
        const Head& head = heads_[vertex];
        return {places_.data() + offset_of(vertex), head.valence, head.closed};
    }
    /// Has the processor fetch where the ring is known from, and later the ring itself: for loops over vertices that
    /// are far apart in memory.
    void fetch_head(Index vertex) const { __builtin_prefetch(&heads_[vertex]); }
    void fetch_ring(Index vertex) const { __builtin_prefetch(places_.data() + offset_of(vertex)); }
    /// Whether all triangles at the vertex are one fan, so that collapses may touch it.
    bool is_manifold(Index vertex) const {
        return heads_[vertex].kind == RingKind::kClosed || heads_[vertex].kind == RingKind::kOpen;
    }
    RingKind kind(Index vertex) const { return heads_[vertex].kind; }

    /// Whether the half-edge collapse that merges `from` into its neighbour `to` keeps the surface a manifold of the
    /// same topology (link condition), a boundary a boundary, and the ring of `to` within kLongestRing or what it
    /// was.
    bool can_collapse(Index from, Index to) const;

    /// Removes `from`; its triangles close up at `to`. @pre can_collapse(from, to).
    void collapse(Index from, Index to);

    /// The rings of all vertices that are left.
    OneRings present_rings(const Execution& execution) const;

    /// Rings that grow stop here.
    static constexpr Index kLongestRing = 16;
    /// A vertex with a longer ring has no collapse: that of `to`, of two vertices or more, would gain all of it but
    /// for up to four.
    static constexpr Index kLongestRemovable = kLongestRing + 2;

  private:
    struct Head {
        Index block;  // of kLongestRing places; longer rings take several, one after another
        Index valence;
        RingKind kind;
        bool closed;
    };

    std::size_t offset_of(Index vertex) const {
        return static_cast<std::size_t>(heads_[vertex].block) * kLongestRing;
    }
    Index* ring_of(Index vertex) { return places_.data() + offset_of(vertex); }
    void replace(Index vertex, Index old_neighbour, Index new_neighbour);
    void erase(Index vertex, Index neighbour);

    std::vector<Index> places_;
    std::vector<Head> heads_;
};

}  // namespace meanvalue
