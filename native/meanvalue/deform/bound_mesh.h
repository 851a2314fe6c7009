// One bound mesh: what depends on the rest shape, the anchor set and the region of influence is done once.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/decoder.h"
#include "meanvalue/deform/binding.h"
#include "meanvalue/deform/binding_input.h"
#include "meanvalue/follow/loose_parts.h"
#include "meanvalue/mesh/components.h"

namespace meanvalue {

/// A mesh as it was given, and what of it may move.
struct RestMesh {
    SharedPositions vertices;
    SharedTriangles faces;
    std::optional<std::vector<char>> roi;
    double diagonal = 0.0;  ///< of its bounding box
    std::vector<SharedPositions> examples;
};

/// A connected part of the region, which is what is free and its surroundings. Each is bound and solved by itself, so
/// that what stands beside it changes none of its bits.
struct BoundPart {
    Index size;  ///< in vertices
    std::shared_ptr<const RegionShape> shape;
    std::shared_ptr<const Decoder> decoder;
    std::vector<AnchorOfRegion> anchors;

    const std::vector<Index>& vertices() const { return shape->region.vertices; }  ///< of the mesh
};

using PartBody = std::function<void(std::size_t number, int threads, Execution& execution)>;

/// Everything that bind makes. Never written to afterwards, so that any number of threads may read it.
class BoundMesh {
  public:
    /// @param earlier a mesh bound before, or nullptr: what does not depend on the anchors is shared with it, and the
    /// rest found along it where that is quicker. The bits are the same. @pre `binding` is of its mesh, region,
    /// method and examples, as its binding_again() is; else InvalidInput.
    /// @throws InvalidInput (numbers out of range, strengths that are not above 0, positions that are not finite, an
    /// anchor named twice, rings that are too long (require_short_rings()), ...),
    ///         SolverFailure, Cancelled.
    /// @param when_coarse see Deformer.
    BoundMesh(const Binding& binding, Execution& execution, const BoundMesh* earlier = nullptr,
              const std::function<void(std::unique_ptr<const BoundMesh>)>& when_coarse = {});
    BoundMesh& operator=(const BoundMesh&) = delete;

    const std::vector<BoundPart>& parts() const { return parts_; }  ///< at least one
    /// Calls body for each: large ones one after another with all threads, others side by side. Each of several has
    /// an execution of its own; the progress of `stage` is that of their vertices.
    void for_parts(const char* stage, int threads, Execution& execution, const PartBody& body) const;
    const BindReport& report() const { return report_; }
    /// How many threads a call may use that asks for `threads`, 0 for as many as it was bound with.
    /// @throws InvalidInput where it is negative.
    int threads_of(int threads) const { return threads == 0 ? threads_ : thread_count(threads); }
    double default_tolerance() const { return default_tolerance_; }
    const std::vector<Index>& anchors() const { return anchors_; }
    const Positions& rest() const { return *mesh_->vertices; }  ///< n x 3
    /// Mesh, region of influence, method, examples, threads, instructions and what becomes of loose parts of this
    /// one; anchors and what belongs to them are to be given.
    Binding binding_again() const;

    /// @throws InvalidInput for weights (k, or empty) of another number, outside [0, 1], or not 1 where an anchor is
    /// hard.
    void check_weights(const std::vector<double>& weights) const;
    /// k x 3: `targets`, and where `weights` (k, or empty: all 1) free an anchor, its place at rest.
    /// @throws InvalidInput, also as check_weights().
    Positions targets_without_gaps(const PositionsView& targets, const std::vector<double>& weights) const;
    /// The decoder's vertices where a solve of a part begins: anchors that are not freed at their targets, all others
    /// at rest, or free ones and soft anchors where they were. @param targets, weights of targets_without_gaps().
    /// @param previous the decoder's vertices before, or nullptr. @param threads as given by threads_of(), here and
    /// below. @throws Cancelled.
    Positions start_of(const BoundPart& part, const PositionsView& targets, const Positions* previous,
                       const std::vector<double>& weights, int threads, const Execution& execution) const;
    /// Of each part the decoder's vertices of a shape to start from, n x 3. @throws InvalidInput, Cancelled.
    std::vector<Positions> parts_of(const PositionsView& start, const Execution& execution) const;
    /// n x 3: the whole mesh with the parts' vertices and the anchors that are met exactly; loose parts carried
    /// along.
    Positions whole_mesh(const std::vector<Positions>& parts, const PositionsView& targets, int threads) const;
    /// n x (e + 1). @param reports of the parts.
    std::vector<double> example_weights(const std::vector<DecodeReport>& reports, int threads) const;
    /// The parts that go along with others, which have no rows.
    const LooseParts& loose_parts() const { return loose_parts_; }

  private:
    BoundMesh(const BoundMesh&) = default;

    void find_parts(const Components& components, const BoundMesh* earlier, Execution& execution);
    void find_anchors(const Binding& binding);
    void fill_report(Components components);

    std::shared_ptr<const RestMesh> mesh_;
    Method method_;
    InstructionSet instructions_;
    LooseRule loose_;
    int threads_;
    double default_tolerance_ = 1e-6;
    std::vector<Index> anchors_;
    std::vector<char> is_fixed_;          // n: hard anchors, what lies outside the region of influence, loose parts
    std::vector<char> is_of_loose_part_;  // k: anchors of a soft border that are carried along
    std::vector<char> is_outside_;        // n: all but this and its surroundings is the region
    LooseParts loose_parts_;
    BindReport report_;
    std::vector<BoundPart> parts_;
    Index region_size_ = 0;  // in vertices, of all parts
};

}  // namespace meanvalue
