// In-between shapes: paper, section 4.3.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <memory>
#include <optional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/deformer.h"

namespace meanvalue {

/// What a Morpher is bound to.
struct MorphBinding {
    /// @param shapes, faces matrices or maps of Eigen's in any layout, which are copied; or what is shared already.
    /// @throws InvalidInput unless all have three columns.
    template <typename Shapes, typename Faces>
    MorphBinding(const Shapes& shapes, const Faces& faces) : faces(share(faces, "faces")) {
        for (const auto& shape : shapes)
            this->shapes.push_back(share(shape, "a shape"));
    }

    std::vector<SharedPositions> shapes;  ///< two or more, n x 3 each
    SharedTriangles faces;                ///< m x 3, of all shapes
    /// A part of the mesh with three or more of these vertices is placed by them instead of all of its vertices.
    std::vector<Index> anchors = {};
    int threads = 0;  ///< 0: every core
    InstructionSet instructions = InstructionSet::kFastest;
};

struct MorphOptions {
    int threads = 0;  ///< 0: as many as it was bound with
    /// Where weights differ between vertices: the shapes that enter only where they have a weight (grafts). They are
    /// placed by what fits best where they enter; the whole is a mix of the others. None: all but the one with the
    /// largest mean weight. Name them where weights change from solve to solve, since that one may change.
    std::optional<std::vector<Index>> parts = {};
};

/// What bind found, and what it cost.
struct MorphReport {
    Index shape_count = 0;
    Index vertex_count = 0;
    Index component_count = 0;
    Timings timings;        ///< seconds by stage
    std::size_t bytes = 0;  ///< held, estimated
};

/// Several shapes of one mesh, to be mixed by weights: expensive to make, cheap to solve. The result depends on the
/// weights alone. docs/algorithm.md, "Blending".
class Morpher {
  public:
    /// @throws InvalidInput that names what is wrong with which shape, SolverFailure, Cancelled.
    Morpher(const MorphBinding& binding, Execution& execution);
    explicit Morpher(const MorphBinding& binding) : Morpher(binding, *std::make_unique<Execution>()) {}

    /// The shape whose cells are the averages of all shapes' cells: each in its local frame, and their rotations.
    /// Each part of the mesh is placed by the best fit to the average positions.
    /// @param weights one for each shape, or for each shape n of them, one for each vertex; divided by their sum.
    /// Solves may run side by side. The same bits for any number of threads.
    /// @throws InvalidInput, SolverFailure, Cancelled; the morpher stays usable.
    Solution solve(const std::vector<double>& weights, const MorphOptions& options = {},
                   const Execution& execution = Execution()) const;

    const MorphReport& report() const { return report_; }

  private:
    struct Bound;

    std::shared_ptr<const Bound> bound_;
    MorphReport report_;
};

}  // namespace meanvalue
