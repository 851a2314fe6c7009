#include "meanvalue/follow/follower.h"

#include <cstddef>
#include <utility>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/follow/loose_parts.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/same_places.h"

namespace meanvalue {
struct Follower::Bound {
    Index carrier_count = 0;
    Positions rest;             // both meshes in one, the carrier first; vertices of seams once
    std::vector<Index> places;  // n: of each vertex there
    LooseParts parts;
    std::vector<FollowKind> kinds;
    std::vector<Index> part_of;
    int threads = 1;

    Triangles join(const FollowBinding& binding, const Execution& execution);
};

/// @return the faces of both. Where a mesh was split, as along the seams of its texture, it is whole again.
Triangles Follower::Bound::join(const FollowBinding& binding, const Execution& execution) {
    const Triangles& carrier_faces = *binding.carrier_faces;
    const Triangles& faces = *binding.faces;
    carrier_count = static_cast<Index>(binding.carrier_vertices->rows());
    const std::vector<Index> corners(faces.data(), faces.data() + faces.size());
    std::vector<Index> starts(static_cast<std::size_t>(faces.rows()));
    for (Index f = 0; f < faces.rows(); ++f)
        starts[f] = 3 * f;
    const std::vector<Index> first = first_of_seams(*binding.vertices, corners, starts, 0.0, execution);
    places.resize(first.size());
    std::vector<Index> kept;
    for (std::size_t v = 0; v < first.size(); ++v) {
        places[v] = carrier_count + static_cast<Index>(kept.size());
        if (first[v] == static_cast<Index>(v)) kept.push_back(first[v]);
    }
    places = picked(places, first);
    rest.resize(carrier_count + static_cast<Index>(kept.size()), 3);
    rest << *binding.carrier_vertices, (*binding.vertices)(kept, Eigen::all);
    std::vector<Index> both(carrier_faces.data(), carrier_faces.data() + carrier_faces.size());
    for (Index f = 0; f < faces.rows(); ++f) {
        const Index a = places[faces(f, 0)], b = places[faces(f, 1)], c = places[faces(f, 2)];
        if (a != b && b != c && c != a) both.insert(both.end(), {a, b, c});
    }
    return Eigen::Map<const Triangles>(both.data(), static_cast<Eigen::Index>(both.size() / 3), 3);
}

Follower::Follower(const FollowBinding& binding, Execution& execution) {
    pin_eigen_cache_sizes();
    require_mesh(*binding.carrier_vertices, *binding.carrier_faces, "carrier_vertices", "carrier_faces");
    require_mesh(*binding.vertices, *binding.faces, "vertices", "faces");
    if (binding.carrier_faces->rows() == 0)
        throw InvalidInput("carrier_faces has no triangles; give the mesh of the surface that is followed");
    execution.begin_stage("follow");
    auto bound = std::make_unique<Bound>();
    bound->threads = thread_count(binding.threads);
    const Triangles faces = bound->join(binding, execution);
    std::vector<char> is_held(bound->rest.rows(), 0);  // vertices without a face hold nothing
    for (const Index corner : binding.carrier_faces->reshaped())
        is_held[corner] = 1;
    const Components components = find_components(bound->rest, faces, is_held, execution);
    bound->parts =
        LooseParts(bound->rest, faces, components, binding.kind, binding.instructions, bound->threads, execution);
    const std::vector<char>& clothes = bound->parts.clothes();
    const std::size_t first = bound->places.empty() ? clothes.size() : components.part_of[bound->carrier_count];
    for (const Index place : bound->places)
        bound->part_of.push_back(components.part_of[place] - static_cast<Index>(first));
    for (std::size_t part = first; part < clothes.size(); ++part)  // those of the mesh are the last ones
        bound->kinds.push_back(clothes[part] ? FollowKind::kCloth : FollowKind::kRigid);
    bound_ = std::move(bound);
}

Positions Follower::follow(const PositionsView& carrier_posed, int threads, const Execution& execution) const {
    require_count("carrier_posed", carrier_posed.rows(), "position", bound_->carrier_count,
                  "vertices of the carrier");
    require_finite(carrier_posed, "carrier_posed");
    require_moderate_extent(carrier_posed);
    Positions positions = bound_->rest;
    positions.topRows(bound_->carrier_count) = carrier_posed;
    bound_->parts.carry(bound_->rest, positions.data(), threads == 0 ? bound_->threads : thread_count(threads),
                        execution);
    return positions(bound_->places, Eigen::all);
}

const std::vector<FollowKind>& Follower::kinds() const {
    return bound_->kinds;
}

const std::vector<Index>& Follower::part_of() const {
    return bound_->part_of;
}

}  // namespace meanvalue
