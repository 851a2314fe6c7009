// What is worn goes along with what is posed: clothes, hair, eyes, buttons on a body.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <memory>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// How a part goes along.
enum class FollowKind {
    kAuto,   ///< by its size and how it lies on the carrier
    kCloth,  ///< it bends with the surface below it
    kRigid,  ///< it keeps its shape
};

/// What a Follower is bound to.
struct FollowBinding {
    /// @param carrier_vertices, carrier_faces, vertices, faces matrices or maps of Eigen's in any layout, which are
    /// copied; or what is shared already. Both meshes at rest, in one space. @throws InvalidInput unless all have
    /// three columns.
    template <typename CarrierVertices, typename CarrierFaces, typename Vertices, typename Faces>
    FollowBinding(const CarrierVertices& carrier_vertices, const CarrierFaces& carrier_faces,
                  const Vertices& vertices, const Faces& faces)
        : carrier_vertices(share(carrier_vertices, "carrier_vertices")),
          carrier_faces(share(carrier_faces, "carrier_faces")),
          vertices(share(vertices, "vertices")),
          faces(share(faces, "faces")) {}

    SharedPositions carrier_vertices;  ///< c x 3
    SharedTriangles carrier_faces;
    SharedPositions vertices;  ///< n x 3
    SharedTriangles faces;
    FollowKind kind = FollowKind::kAuto;  ///< of all parts; one of fewer than four vertices is rigid all the same
    int threads = 0;                      ///< 0: every core
    InstructionSet instructions = InstructionSet::kFastest;
};

/// A mesh that goes along with another, its carrier. Clothes bend with the surface below them and do not sink into
/// it; small things are rigid, and go along with the carrier or the clothes, whichever is nearer. Where it goes
/// depends on the carrier's pose alone, without a jump; a similarity takes it along exactly. docs/algorithm.md,
/// "Clothes".
class Follower {
  public:
    /// @throws InvalidInput that names what is wrong with which array, Cancelled. Cost: n log n.
    Follower(const FollowBinding& binding, Execution& execution);
    explicit Follower(const FollowBinding& binding) : Follower(binding, *std::make_unique<Execution>()) {}

    /// n x 3: where the mesh goes to. Calls may run side by side. The same bits for any number of threads.
    /// @param carrier_posed c x 3. @param threads 0: as many as it was bound with. @throws InvalidInput, Cancelled.
    Positions follow(const PositionsView& carrier_posed, int threads = 0,
                     const Execution& execution = Execution()) const;

    /// kCloth or kRigid for each connected part, in the order of their first vertices.
    const std::vector<FollowKind>& kinds() const;
    /// n: the part of each vertex.
    const std::vector<Index>& part_of() const;

  private:
    struct Bound;

    std::shared_ptr<const Bound> bound_;
};

}  // namespace meanvalue
