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
#include "meanvalue/deform/loose_parts.h"
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

    const Decoder& decoder() const { return *decoder_; }
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
    /// Whether start_of_region() takes them. @param weights that check_weights() takes.
    bool can_be_placed(const PositionsView& targets, const std::vector<double>& weights) const;
    /// k x 3: `targets`, and where `weights` (k, or empty: all 1) free an anchor, its place at rest.
    /// @throws as check_weights().
    Positions targets_without_gaps(const PositionsView& targets, const std::vector<double>& weights) const;
    /// The decoder's vertices where a solve begins: anchors that are not freed at their targets, all others at rest,
    /// or free ones and soft anchors where they were. @param previous the decoder's vertices before, or nullptr.
    /// @param weights that targets_without_gaps() took. @param threads as given by threads_of(), here and below.
    /// @throws InvalidInput, Cancelled.
    Positions start_of_region(const PositionsView& targets, const Positions* previous,
                              const std::vector<double>& weights, int threads, const Execution& execution) const;
    /// The decoder's vertices of a shape to start from, n x 3. @throws InvalidInput, Cancelled.
    Positions region_of(const PositionsView& start, int threads, const Execution& execution) const;
    /// n x 3: the whole mesh with the decoder's vertices and the anchors that are met exactly; loose parts carried
    /// along.
    Positions whole_mesh(const Positions& region, const PositionsView& targets, int threads) const;
    /// n x (e + 1). @param weights of the decoder, or empty: there are no examples.
    std::vector<double> example_weights(const ExampleWeights& weights, int threads) const;
    /// The parts that go along with others, which have no rows.
    const LooseParts& loose_parts() const { return loose_parts_; }

  private:
    BoundMesh(const BoundMesh&) = default;

    std::shared_ptr<const RegionShape> shape_for(const Components& components, const BoundMesh* earlier,
                                                 Execution& execution);
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
    std::vector<char> is_outside_;        // n: all but this and its surroundings is the decoder's region
    std::vector<Index> region_vertices_;  // the decoder's vertex numbers in the mesh
    std::vector<Index> anchor_rows_;      // k: the decoder's vertex of each anchor, or -1
    LooseParts loose_parts_;
    BindReport report_;
    std::shared_ptr<const Decoder> decoder_;
};

}  // namespace meanvalue
