// What a mesh is bound to, and what bind reports.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/component.h"

namespace meanvalue {

/// How free vertices are found from the anchors.
enum class Method {
    kFast,   ///< converged, with rigidity, at screen rate
    kPaper,  ///< hierarchical decoding: section 3
    kFull,   ///< equation 15 to convergence from the rest pose: section 2.3
};

/// What becomes of parts that have neither an anchor nor a fixed vertex.
enum class LooseRule {
    kStay,    ///< at rest
    kFollow,  ///< the nearest part that is fixed
};

/// What None stands for.
constexpr double kDefaultRigidity = 15.0;

/// What a Deformer is bound to.
struct Binding {
    /// @param vertices, faces matrices or maps of Eigen's in any layout, which are copied; or what is shared already.
    /// All other settings are given by their names. @throws InvalidInput unless both have three columns.
    template <typename Vertices, typename Faces>
    Binding(const Vertices& vertices, const Faces& faces, std::vector<Index> anchors,
            std::optional<std::vector<char>> roi = {})
        : vertices(share(vertices, "vertices")),
          faces(share(faces, "faces")),
          anchors(std::move(anchors)),
          roi(std::move(roi)) {}
    /// With the anchors in a vector of Eigen's, as libigl has them.
    template <typename Vertices, typename Faces, typename Derived>
    Binding(const Vertices& vertices, const Faces& faces, const Eigen::DenseBase<Derived>& anchors)
        : Binding(vertices, faces, std::vector<Index>(anchors.derived().begin(), anchors.derived().end())) {}

    SharedPositions vertices;  ///< n x 3 rest positions
    SharedTriangles faces;     ///< m x 3
    std::vector<Index> anchors;
    std::optional<std::vector<char>> roi;  ///< n flags, true may move; none: every vertex may
    Method method = Method::kFast;
    int threads = 0;           ///< 0: every core
    std::uint64_t memory = 0;  ///< bytes that a bind may take; 0: as much as there is (physical_memory())
    /// k numbers, or empty: anchors of one handle move rigidly together, so that far rotations can be followed along
    /// their way. Without, anchors joined by edges make a handle. Used by Method::kFast.
    std::vector<Index> handles = {};
    /// How much lengths count, 0 or more; see DeformationEnergy. None: the method's default. Only Method::kFast knows
    /// any but 0, which is the paper's energy.
    std::optional<double> rigidity = {};
    /// n factors from 1e-6 to 1e6, or empty: how many times as much lengths count around each vertex. With 30
    /// along limbs and 1 around joints, limbs bend at their joints. Soft anchors keep their reach: all are stronger
    /// by the root of the factors' geometric mean. Method::kFast only.
    std::vector<double> stiffness = {};
    /// k strengths, or empty. Infinity: the anchor is met exactly, as all are where none are given. A number s above
    /// 0, at most 1e9: a soft anchor, a free vertex with the energy s |v - target|^2 besides that of the shape
    /// (DeformationEnergy), in squared units as that is, so that s has no unit. s / c for each of c vertices of a
    /// handle makes a spring of s for the handle; the energy of the shape falls as 1 / n in finer meshes of n
    /// vertices. Must be inside `roi`. Method::kFast only.
    std::vector<double> strengths = {};
    /// Solve with what all processors of an architecture have: slower, with the same bits on each of them.
    InstructionSet instructions = InstructionSet::kFastest;
    /// k flags, or empty: anchors that only hold a region's soft border to its rest shape. A part that has no others
    /// is loose.
    std::vector<char> is_border = {};
    LooseRule loose = LooseRule::kStay;
    /// Shapes that the mesh is known to take, n x 3 each, any rotation and place: the mesh bends as they show it.
    /// Method::kFast only.
    std::vector<SharedPositions> examples = {};
};

/// What bind found, and what it cost.
struct BindReport {
    Index vertex_count = 0;
    Index free_count = 0;  ///< vertices that are solved for: not those of loose parts
    Index anchor_count = 0;
    Index row_count = 0;                ///< residuals that take part in a solve
    std::vector<Index> level_sizes;     ///< free vertices in each level, finest first
    Index longest_ring = 0;             ///< of any row in any level
    Index detached_triangle_count = 0;  ///< triangles of the region that fit no manifold; see collect_one_rings()
    std::vector<Index> guarded;         ///< vertices encoded by a fallback rule
    std::map<std::string, std::vector<Index>> guarded_by_reason;  ///< the vertices that each reason applies to
    std::vector<Component> components;  ///< the parts of the mesh and what their fixed vertices leave open
    std::vector<Index> carriers;        ///< of each of these: the one that carries it along (LooseParts), or -1
    std::vector<Index> part_of;         ///< n: the part of each vertex, of `components`
    Timings timings;                    ///< seconds by stage, of which some overlap, and "total"
    std::size_t bytes = 0;              ///< held by what was bound and a workspace, estimated
};

}  // namespace meanvalue
