#include "meanvalue/hierarchy/removal_rules.h"

#include "meanvalue/encoding/ring_extension.h"

namespace meanvalue {

RemovalRules::RemovalRules(const RingMesh& mesh, const OneRings& rings, const PositionsView& positions,
                           const std::vector<char>& is_fixed, const CoarseningOptions& options)
    : mesh_(mesh), positions_(positions), is_fixed_(is_fixed) {
    if (options.thin_out_fixed) parts_ = find_fixed_parts(rings, positions, is_fixed, options.handles);
    if (!options.is_soft.empty()) soft_parts_ = find_fixed_parts(rings, positions, options.is_soft, options.handles);
}

bool RemovalRules::is_removable(Index vertex) const {
    if (!mesh_.is_manifold(vertex)) return false;
    if (is_soft(vertex)) return !soft_parts_.is_extreme[vertex];
    return !is_fixed_[vertex] || (!parts_.part.empty() && !parts_.is_extreme[vertex]);
}

bool RemovalRules::may_become(Index vertex, Index to) const {
    if (is_soft(vertex)) return soft_parts_.part[vertex] == soft_parts_.part[to];
    return !is_fixed_[vertex] || parts_.part[vertex] == parts_.part[to];
}

Collapse RemovalRules::cheapest(Index vertex, CollapseCost& cost) const {
    cost.set_vertex(vertex, mesh_.ring(vertex));
    return cost.cheapest([&](Index to) { return may_become(vertex, to); });
}

bool RemovalRules::has_good_stencil(Index vertex, RingEncoder& encoder) const {
    const RingView ring = mesh_.ring(vertex);
    if (!spans_a_plane(positions_, ring.vertices, ring.valence)) return false;
    return (encoder.encode(vertex, ring.vertices, ring.valence) & ~kOnRingEdge) == 0;
}

}  // namespace meanvalue
