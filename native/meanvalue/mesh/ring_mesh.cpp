#include "meanvalue/mesh/ring_mesh.h"

#include <algorithm>

namespace meanvalue {

RingMesh::RingMesh(const OneRings& rings, const Execution& execution) {
    execution.check();
    heads_.reserve(rings.vertex_count());
    places_.reserve(static_cast<std::size_t>(rings.vertex_count()) * kLongestRing);
    Index block = 0;
    for (Index v = 0; v < rings.vertex_count(); ++v) {
        const Index valence = rings.valence(v);
        heads_.push_back({block, valence, rings.kinds[v], rings.closed[v] != 0});
        block += std::max<Index>(1, (valence + kLongestRing - 1) / kLongestRing);
        places_.resize(static_cast<std::size_t>(block) * kLongestRing);
        std::copy(rings.begin(v), rings.end(v), ring_of(v));
    }
}

bool RingMesh::can_collapse(Index from, Index to) const {
    if (!is_manifold(from) || !is_manifold(to)) return false;
    const RingView ring = this->ring(from);
    const RingView target = this->ring(to);
    if (ring.valence < 3) return false;
    const Index place = static_cast<Index>(std::find(ring.begin(), ring.end(), to) - ring.begin());
    if (place == ring.valence) return false;
    // A boundary vertex that moves inwards would cut the surface's corner off.
    if (!ring.closed && place != 0 && place != ring.valence - 1) return false;
    // `to` gains the ring of `from` but for itself and the neighbors they share, and loses `from`.
    const Index shared = ring.closed ? 2 : 1;
    const Index valence = target.valence - 1 + ring.valence - 1 - shared;
    // Below that, two triangles back to back would be left of a tetrahedron.
    if (valence < (target.closed ? 3 : 2)) return false;
    if (valence > std::max(kLongestRing, target.valence)) return false;
    // The link condition: no common neighbors but those next to the edge.
    const Index next = place + 1 < ring.valence ? place + 1 : ring.closed ? 0 : -1;
    const Index last = place > 0 ? place - 1 : ring.closed ? ring.valence - 1 : -1;
    for (Index k = 0; k < ring.valence; ++k) {
        if (k == place || k == next || k == last) continue;
        if (std::find(target.begin(), target.end(), ring.vertices[k]) != target.end()) return false;
    }
    return true;
}

void RingMesh::collapse(Index from, Index to) {
    const RingView ring = this->ring(from);
    const Index valence = ring.valence;
    const Index place = static_cast<Index>(std::find(ring.begin(), ring.end(), to) - ring.begin());
    // The ring of `from` from `to` on, without `to` and the neighbors shared: what `to` gains, in its order.
    Index first = place + 2;
    Index count = valence - 3;
    if (!ring.closed) {
        count = valence - 2;
        if (place != 0) first = 0;
    }
    const auto place_in_ring = [&](Index k) { return k < valence ? k : k - valence; };

    Head& head = heads_[to];
    Index* merged = ring_of(to);
    Index* const gap = std::find(merged, merged + head.valence, from);
    if (count == 0) {
        std::copy(gap + 1, merged + head.valence, gap);
    } else if (count > 1) {
        std::copy_backward(gap + 1, merged + head.valence, merged + head.valence - 1 + count);
    }
    for (Index k = 0; k < count; ++k)
        gap[k] = ring.vertices[place_in_ring(first + k)];
    head.valence += count - 1;

    for (Index k = 0; k < count; ++k)
        replace(ring.vertices[place_in_ring(first + k)], from, to);
    if (ring.closed || place == 0) erase(ring.vertices[place_in_ring(place + 1)], from);
    if (ring.closed || place != 0) erase(ring.vertices[place_in_ring(place + valence - 1)], from);
    heads_[from].valence = 0;
    heads_[from].kind = RingKind::kAbsent;
}

void RingMesh::replace(Index vertex, Index old_neighbour, Index new_neighbour) {
    Index* const ring = ring_of(vertex);
    Index* const end = ring + heads_[vertex].valence;
    Index* const found = std::find(ring, end, old_neighbour);
    if (found != end) *found = new_neighbour;  // of a non-manifold vertex one fan is known; it may be in another
}

void RingMesh::erase(Index vertex, Index neighbour) {
    Index* const ring = ring_of(vertex);
    Index* const end = ring + heads_[vertex].valence;
    Index* const found = std::find(ring, end, neighbour);
    if (found == end) return;
    std::copy(found + 1, end, found);
    --heads_[vertex].valence;
}

OneRings RingMesh::present_rings(const Execution& execution) const {
    OneRings rings;
    rings.reserve(vertex_count());
    execution.check();
    for (Index v = 0; v < vertex_count(); ++v) {
        const RingView around = ring(v);
        rings.append(around.begin(), around.end(), kind(v), around.closed);
    }
    return rings;
}

}  // namespace meanvalue
