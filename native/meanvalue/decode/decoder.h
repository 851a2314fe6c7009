// What all methods of finding the free vertices have in common, and what each binds first: a region, its rings and
// its encoding.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/instruction_set.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/examples/example_space.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/region.h"

namespace meanvalue {

/// What depends on the shape of a region alone, whatever is fixed in it: everything that is bound to it shares one.
struct RegionShape {
    Region region;  ///< without is_fixed
    OneRings rings;
    Encoding encoding;                      ///< by those rings
    double size = 0.0;                      ///< mean_diagonal()
    std::optional<ExampleShapes> examples;  ///< or none
    Timings timings;                        ///< seconds by stage
};

/// A region with what is fixed in it.
struct EncodedRegion {
    std::shared_ptr<const RegionShape> shape;
    std::vector<char> is_fixed;                              ///< n flags
    InstructionSet instructions = InstructionSet::kFastest;  ///< that it is to be solved with
    Timings timings = {};                                    ///< seconds by stage
    /// The order of elimination of a decoder of this shape with other fixed vertices, or nullptr: one is found.
    std::shared_ptr<const std::vector<Index>> elimination_order = nullptr;
};

/// @param examples of the whole mesh, or none. @param size_of_point what it has where all is in one place.
/// @throws Cancelled. Cost: linear.
std::shared_ptr<const RegionShape> encode_shape(Region region, int threads, Execution& execution,
                                                const std::vector<SharedPositions>& examples = {},
                                                double size_of_point = 1.0);

struct DecodeOptions {
    /// Share of the bounding-box diagonal that a vertex may still move, for decoders that stop by tolerance.
    double tolerance = 1e-6;
    int max_iterations = 100;
    double enough_energy = 0.0;  ///< from an earlier shape: also end where the energy is not above this
    /// Where to start, or nullptr: an earlier shape of the region, n x 3, with its fixed vertices where they were
    /// then.
    const Positions* previous = nullptr;
    /// k x 3, in the order of all anchors: where soft ones are pulled to. Decoders without any do not read it.
    const PositionsView* targets = nullptr;
    /// k numbers from 0 to 1, in the order of all anchors, 1 for hard ones; or nullptr: what the strength of each
    /// soft anchor is multiplied with. At 0 it is free, and its target is not read.
    const std::vector<double>* weights = nullptr;
    int threads = 0;  ///< 0: as many as it was bound with
    /// The workspace belongs to a drag: a row of solves of which each begins at the answer of the one before. The
    /// solve goes on with what the workspace remembers of these, and adds to it.
    bool in_drag = false;
    /// Nothing is to be left to a next solve. What the workspace remembers stays as it is, so that whoever asks for
    /// this may do so in two halves, and forgets it then.
    bool is_last = false;
    bool is_kept = false;  ///< SolveOptions::is_kept
};

struct DecodeReport {
    std::vector<double> energies = {
        0.0};                         ///< G over the rows that depend on free vertices: at the start, ..., at the end
    double initial_gradient = 0.0;    ///< norm of the energy's derivative at the start
    double gradient = 0.0;            ///< and at the end, or where it was last linearized
    Eigen::MatrixXd example_weights;  ///< ExampleWeights, or empty
    int iterations = 0;
    int all_iterations = 0;  ///< with those of coarser levels and of the stages before the last
    bool converged = true;
    std::string stop_reason;
    Timings timings;  ///< seconds by stage
};

/// What a solve writes besides its result. One solve at a time uses it; kept for the next, it spares taking memory.
/// That of a drag remembers its solves, so that the next takes fewer iterations.
class Workspace {
  public:
    Workspace() = default;
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    virtual ~Workspace() = default;

    virtual void forget() {}  ///< what it remembers of a drag
};

/// A connected region bound for decoding, in its own vertex numbers. Expensive to make, cheap to use; never written
/// to after finish(), so that any number of threads may decode with it, each with a workspace of its own.
class Decoder {
  public:
    Decoder(const Decoder&) = delete;
    Decoder& operator=(const Decoder&) = delete;
    virtual ~Decoder() = default;

    /// Before finish(): one that solves by the coarsest level alone; or nullptr.
    virtual std::unique_ptr<const Decoder> early() const { return nullptr; }
    /// Binds what early() does without; to be called once, before anything else. @throws as the constructor.
    virtual void finish(Execution& /*execution*/) {}

    /// @throws Cancelled, std::bad_alloc.
    virtual std::unique_ptr<Workspace> make_workspace(const Execution& execution) const = 0;

    /// @param positions of the region's vertices: fixed ones in place, free ones at rest or where they start,
    /// soft anchors then at their targets if there is no earlier shape; receives the result. Left in any state on an
    /// exception. @param workspace made by this decoder; it remembers no new answer before remember(), and less of
    /// the way to the old one; what it has asked of the bound mesh it keeps. The same bits for any number of threads;
    /// they depend on solves before in a drag only.
    /// @throws Cancelled, SolverFailure.
    virtual DecodeReport decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                                Execution& execution) const = 0;

    /// In a drag, once the answer of decode() is taken, from an earlier shape and not the last: the next goes on
    /// there.
    virtual void remember(const Positions& /*answer*/, Workspace& /*workspace*/) const {}

    /// What decode() is going to give in a drag, as far as the answers before tell: as decode(), but at once, also
    /// while it is at work with the same workspace.
    /// @param positions receives the free vertices; others are left in any state. @return false where too little is
    /// known of such a move.
    virtual bool draft(const DecodeOptions& /*options*/, Workspace& /*workspace*/, Positions& /*positions*/,
                       const Execution& /*execution*/) const {
        return false;
    }

    const Encoding& encoding() const { return encoding_; }  ///< of the region at full resolution
    Index detached_triangle_count() const { return shape_->rings.detached_triangle_count; }
    /// Of the region's vertices, or nullptr: EncodedRegion::elimination_order of the next.
    const std::shared_ptr<const std::vector<Index>>& elimination_order() const { return elimination_order_; }
    const Timings& bind_timings() const { return bind_timings_; }
    virtual Index row_count() const = 0;  ///< residuals that take part
    /// What was bound and a workspace hold, estimated: what models of 7,000 to 50,000 vertices took for each free
    /// vertex, and the factors.
    virtual std::size_t bytes() const = 0;
    virtual std::vector<Index> level_sizes() const = 0;  ///< free vertices in each level, finest first
    virtual Index longest_ring() const = 0;              ///< in any level, and of any vertex when it was removed

  protected:
    /// Finds it where no earlier decoder has. @throws Cancelled.
    const std::vector<Index>& find_order(int threads, Execution& execution);

    Decoder(EncodedRegion& shape, int threads)
        : threads_(threads),
          instructions_(shape.instructions),
          shape_(std::move(shape.shape)),
          rest_(shape_->region.positions),
          encoding_(shape_->encoding),
          is_fixed_(std::move(shape.is_fixed)),
          elimination_order_(std::move(shape.elimination_order)),
          bind_timings_(std::move(shape.timings)) {}

    int threads_for(const DecodeOptions& options) const { return options.threads > 0 ? options.threads : threads_; }

    int threads_;
    InstructionSet instructions_;
    std::shared_ptr<const RegionShape> shape_;
    const Positions& rest_;     // n x 3, of the region
    const Encoding& encoding_;  // of these
    std::vector<char> is_fixed_;
    std::shared_ptr<const std::vector<Index>> elimination_order_;
    Timings bind_timings_;
};

}  // namespace meanvalue
