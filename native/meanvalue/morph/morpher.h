// In-between shapes: paper, section 4.3.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/deformer.h"
#include "meanvalue/encoding/encoding_blend.h"

namespace meanvalue {

/// What none stands for in MorphBinding::hold.
constexpr double kDefaultHold = 1000.0;

/// What a Morpher is bound to.
struct MorphBinding {
    std::vector<PositionsView> shapes;  ///< two or more, n x 3 each
    TrianglesView faces;                ///< m x 3, of all shapes
    /// Vertices that are put where the turned and stretched cells of all shapes put them, and held there.
    std::vector<Index> anchors = {};
    std::optional<double> rigidity = {};  ///< how much lengths count, 0 or more; none: the default, kDefaultRigidity
    /// How much the shape is held where its cells at the average of their turns put it; none: the default.
    std::optional<double> hold = {};
    int threads = 0;  ///< 0: every core
    InstructionSet instructions = InstructionSet::kFastest;
};

struct MorphOptions {
    std::optional<double> tolerance;  ///< as SolveOptions::tolerance; none: 1e-4, of drafts 3e-3
    int max_iterations = 1000;
    int threads = 0;  ///< 0: as many as it was bound with
    /// For a slider that is being dragged: few iterations, from where the last solve ended if that was of nearly the
    /// same weights. What it gives depends on that one.
    bool is_draft = false;
    /// Where weights differ between vertices: the shapes that enter only where they have a weight, placed by what
    /// fits best where they enter; the whole is a mix of the others. None: all but the one with the largest mean
    /// weight. Name them where weights change from solve to solve, since that one may change.
    std::optional<std::vector<Index>> parts = {};
};

/// What bind found, and what it cost.
struct MorphReport {
    Index shape_count = 0;
    Index vertex_count = 0;
    Index component_count = 0;
    std::vector<Index> guarded;  ///< vertices encoded by a fallback rule, in all shapes
    Timings timings;             ///< seconds by stage
    std::size_t bytes = 0;       ///< held, and about what one solve at a time adds
};

/// Several shapes of one mesh, encoded alike, to be mixed by weights: expensive to make, cheap to solve. What it
/// gives depends on the weights alone, not on the solves before, but for drafts.
class Morpher {
  public:
    /// @throws InvalidInput that names what is wrong with which shape, SolverFailure, Cancelled.
    Morpher(const MorphBinding& binding, Execution& execution);
    ~Morpher();

    /// The shape whose encoding and whose cells are the averages of all shapes'. A part of the mesh without anchors
    /// is placed by the best fit to the average positions.
    /// @param weights one for each shape, or for each shape n of them, one for each vertex; divided by their sum.
    /// @param start n x 3, a shape to begin from; none: the cells, each turned by the average of its turns.
    /// Solves may run side by side. The same bits for any number of threads.
    /// @throws InvalidInput, SolverFailure, Cancelled; the morpher stays usable.
    Solution solve(const std::vector<double>& weights, const std::optional<PositionsView>& start,
                   const MorphOptions& options, Execution& execution) const;

    const MorphReport& report() const { return report_; }

  private:
    struct Bound;
    struct Workspace;
    class Solve;

    std::unique_ptr<Workspace> take_workspace(const Execution& execution) const;
    void give_back(std::unique_ptr<Workspace> workspace) const;

    std::unique_ptr<const Bound> bound_;
    MorphReport report_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<Workspace>> idle_;
};

/// Makes a Morpher on a thread of its own: see bind_detached().
std::unique_ptr<Morpher> bind_morph_detached(const MorphBinding& binding,
                                             const std::shared_ptr<Execution>& execution);

}  // namespace meanvalue
