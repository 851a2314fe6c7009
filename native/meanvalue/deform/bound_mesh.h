// One bound mesh: what depends on the rest shape, the anchor set and the region of influence is done once.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/decoder.h"
#include "meanvalue/deform/loose_parts.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// How free vertices are found from the anchors.
enum class Method {
    kFast,   ///< converged, with rigidity, at screen rate
    kPaper,  ///< hierarchical decoding: section 3
    kFull,   ///< equation 15 to convergence from the rest pose: section 2.3
};

/// What None stands for.
constexpr double kDefaultRigidity = 15.0;

/// @throws InvalidInput for an unknown name, listing the known ones.
Method method_from_name(const std::string& name);

/// @throws InvalidInput for an unknown name, listing the known ones.
LooseRule loose_rule_from_name(const std::string& name);

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

    SharedPositions vertices;  ///< n x 3 rest positions
    SharedTriangles faces;     ///< m x 3
    std::vector<Index> anchors;
    std::optional<std::vector<char>> roi;  ///< n flags, true may move; none: every vertex may
    Method method = Method::kFast;
    int threads = 0;  ///< 0: every core
    /// k numbers, or empty: anchors of one handle move rigidly together, so that far turns can be followed along
    /// their way. Without, anchors joined by edges make a handle. Used by Method::kFast.
    std::vector<Index> handles = {};
    /// How much lengths count, 0 or more; see DeformationEnergy. None: the method's default. Only Method::kFast knows
    /// any but 0, which is the paper's energy.
    std::optional<double> rigidity = {};
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
};

/// What bind found, and what it cost.
struct BindReport {
    Index vertex_count = 0;
    Index free_count =
        0;  ///< vertices that are solved for: not those of parts without a single anchor or fixed vertex
    Index anchor_count = 0;
    Index row_count = 0;             ///< residuals that take part in a solve
    std::vector<Index> level_sizes;  ///< free vertices in each level, finest first
    Index longest_ring = 0;          ///< of any row in any level
    Index detached_triangle_count =
        0;  ///< triangles that fit no manifold; see TriangleMesh. Like `guarded`, of the part that takes part
    std::vector<Index> guarded;                                   ///< vertices encoded by a fallback rule
    std::map<std::string, std::vector<Index>> guarded_by_reason;  ///< the vertices that each reason applies to
    std::vector<Component> components;  ///< the parts of the mesh and what their fixed vertices leave open
    std::vector<Index> carriers;        ///< of each of these: the one that carries it along (LooseParts), or -1
    std::vector<Index> part_of;         ///< n: the part of each vertex, of `components`
    Timings timings;                    ///< seconds by stage
    std::size_t bytes = 0;              ///< held by what was bound
};

/// A mesh as it was given, and what of it may move.
struct RestMesh {
    SharedPositions vertices;
    SharedTriangles faces;
    std::optional<std::vector<char>> roi;
    double diagonal = 0.0;  ///< of its bounding box
};

/// Everything that bind makes. Never written to afterwards, so that any number of threads may read it.
class BoundMesh {
  public:
    /// @param earlier a mesh bound before, or nullptr. Where `binding` has the same mesh, region and method, as its
    /// binding_again() has, what does not depend on the anchors is shared with it, and the rest found along it where
    /// that is quicker. The bits are the same.
    /// @throws InvalidInput (numbers out of range, strengths that are not above 0, positions that are not finite, an
    /// anchor named twice, rings that are too long (RingRoom), ...),
    ///         SolverFailure, Cancelled.
    BoundMesh(const Binding& binding, Execution& execution, const BoundMesh* earlier = nullptr);
    BoundMesh(const BoundMesh&) = delete;
    BoundMesh& operator=(const BoundMesh&) = delete;

    const Decoder& decoder() const { return *decoder_; }
    const BindReport& report() const { return report_; }
    /// That a call may use which asks for `threads`, 0 for as many as it was bound with.
    int threads_of(int threads) const { return threads > 0 ? threads : threads_; }
    double default_tolerance() const { return default_tolerance_; }
    const std::vector<Index>& anchors() const { return anchors_; }
    const Positions& rest() const { return *mesh_->vertices; }  ///< n x 3
    /// Mesh, region of influence, method, threads, instructions and what becomes of loose parts of this one; anchors
    /// and what belongs to them are to be given.
    Binding binding_again() const;

    /// @throws InvalidInput for weights (k, or empty) of another number, outside [0, 1], or not 1 where an anchor is
    /// hard.
    void check_weights(const std::vector<double>& weights) const;
    /// Whether place_anchors() takes them. @param weights that check_weights() takes.
    bool can_be_placed(const PositionsView& targets, const std::vector<double>& weights) const;
    /// k x 3: `targets`, and where `weights` (k, or empty: all 1) free an anchor, its place at rest.
    /// @throws as check_weights().
    Positions targets_without_gaps(const PositionsView& targets, const std::vector<double>& weights) const;
    /// n x 3: the rest shape with the anchors that are not freed at their targets and everything else that may move
    /// at `start`, where given. @param weights that targets_without_gaps() took. @param threads as given by
    /// threads_of(), here and below. @throws InvalidInput, Cancelled.
    Positions place_anchors(const PositionsView& targets, const std::optional<PositionsView>& start,
                            const std::vector<double>& weights, int threads, const Execution& execution) const;
    /// The rows of `positions` (n x 3) that belong to the decoder's vertices. @throws Cancelled.
    Positions rows_of_region(const PositionsView& positions, int threads, const Execution& execution) const;
    /// What may move of them put back.
    void put_rows_of_region(const Positions& rows, Positions& positions, int threads) const;
    /// The parts that go along with others, which have no rows.
    const LooseParts& loose_parts() const { return loose_parts_; }

  private:
    std::shared_ptr<const RegionShape> shape_for(const std::vector<char>& is_fixed, const Components& components,
                                                 const BoundMesh* earlier, Execution& execution);
    void fill_report(Components components);

    std::shared_ptr<const RestMesh> mesh_;
    Method method_;
    InstructionSet instructions_;
    LooseRule loose_;
    int threads_;
    double default_tolerance_ = 1e-6;
    std::vector<Index> anchors_;
    std::vector<char> is_fixed_;          // n: hard anchors, what lies outside the region of influence, loose parts
    std::vector<char> is_let_go_;         // k: anchors of a soft border of a loose part, which hold nothing
    std::vector<char> cut_out_by_;        // n: what the region is the surroundings of the rest of
    std::vector<Index> region_vertices_;  // the decoder's vertex numbers in the mesh
    LooseParts loose_parts_;
    BindReport report_;
    std::unique_ptr<const Decoder> decoder_;
};

}  // namespace meanvalue
