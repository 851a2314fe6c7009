// What FastDecoder binds and FastSolve solves: the levels, their energies, and their factored Hessians; and what a
// solve writes.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/decode/fast/handle_paths.h"
#include "meanvalue/decode/fast/secant_predictor.h"
#include "meanvalue/decode/fast/soft_constraints.h"
#include "meanvalue/examples/example_space.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/lbfgs.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// The drivers of a shape (see SecantPredictor), by handle.
struct DrivingHandles {
    /// @param rest d x 3, the drivers at rest; @param piece_of d, the handle of each, numbered from 0.
    DrivingHandles(const Positions& rest, const std::vector<Index>& piece_of);

    std::vector<std::vector<Index>> pieces;  ///< the drivers of each handle
    Positions places;                        ///< d x 3, at rest from the middle of its handle, whose spread is 1
    std::vector<char> has_extent;            ///< of each handle: whether it is more than a point
};

/// The answer to a handle's move is linear in it, and an affine move of a handle has twelve numbers. So four fields
/// over the free vertices, each a solve of one column, answer every rigid move of a handle, in any pose of it.
class HandleResponses {
  public:
    /// |V'| rows: the answers to the three axes of `places`, and to a translation.
    using Fields = Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor>;
    /// The Hessian's answer, |V'| x 3, to moves of the drivers, d x 3.
    using Hessian = std::function<Positions(const Positions& moves)>;

    HandleResponses() = default;
    explicit HandleResponses(const DrivingHandles& handles) : handles_(&handles) {}

    /// Numbers of the handles of which some driver moves by more than `least`; none where they are too many to be
    /// kept.
    /// @param moves d x 3.
    std::vector<Index> moving(const Positions& moves, double least) const;
    /// Those of `handles` that have not been asked for.
    std::vector<Index> unknown(const std::vector<Index>& handles) const;
    /// The fields of handles, to be kept(): two solves for one, a single one for up to three that are points.
    std::vector<Fields> ask(const std::vector<Index>& handles, const Hessian& hessian) const;
    /// Keeps fields of handles that are all moving(). Others go where they would be too many.
    void keep(const std::vector<Index>& handles, std::vector<Fields> fields, const std::vector<Index>& moving);
    void forget() { known_.clear(); }

    /// Moves the free vertices in `positions` (n x 3) as far as handles are known and their moves affine.
    /// @param moves d x 3; receives what is not answered.
    void answer(Positions& moves, const Unknowns& unknowns, Positions& positions, int threads,
                const Execution& execution) const;

  private:
    struct Known {
        Index handle;
        Fields fields;
    };

    const DrivingHandles* handles_ = nullptr;
    std::vector<Known> known_;
};

/// A rigidity, and the energy's initial Hessian with it: its factor, and its block of the fixed vertices.
struct FastStage {
    double rigidity = 0.0;
    SupernodalFactor factor;
    FixedCoupling coupling;
};

/// One mesh of the hierarchy, with the energy on it at one or more rigidities.
struct FastLevel {
    Unknowns unknowns;
    std::unique_ptr<const DeformationEnergy> energy;
    const Encoding* encoding = nullptr;
    std::shared_ptr<const ExampleSpace> examples;  ///< on this level; or none
    std::vector<FastStage> stages;                 ///< stiffest first; the last has the rigidity asked for
};

/// What drives a shape: the fixed vertices that the energy depends on, in `positions`, then the rows of soft anchors.
Positions drivers_of(const FastLevel& level, const Positions& positions, const Positions& soft);

struct FastProblem {
    const Positions& rest;        ///< of the region, n x 3
    std::vector<char> is_fixed;   ///< n flags
    std::vector<char> is_anchor;  ///< n flags: fixed vertices and soft anchors
    double rigidity = 0.0;
    double size = 0.0;
    std::vector<SoftAnchor> soft;  ///< by ascending vertex
    std::vector<double>
        carrying;  ///< n: weight of each vertex when the whole is carried; empty: all anchors are hard
    std::vector<double> stiffness;  ///< n factors of the lengths around each vertex; or empty: 1
    /// Its levels are `levels` from the second on; empty where the mesh is small.
    std::shared_ptr<const Hierarchy> hierarchy = std::make_shared<const Hierarchy>();
    std::shared_ptr<const HandlePaths> handles;
    std::shared_ptr<const DrivingHandles> driving;  ///< none where nothing is free
    /// The whole mesh first, the coarsest last; of an early one the coarsest alone.
    std::vector<std::shared_ptr<const FastLevel>> levels;
};

/// What a solve writes besides its result.
struct FastWorkspace : Workspace {
    /// For one level.
    struct OfLevel {
        DeformationEnergy::Workspace energy;
        Lbfgs minimiser;
        std::vector<DiagonalDowndate> downdates;  // for each stage
        Encoding blended;                         // of the examples
        RestCells blended_cells;
    };

    void forget() override {
        const std::lock_guard<std::mutex> lock(drafting);
        predictor.end();
        is_drafting = false;
        keeps_history = false;
    }

    std::vector<OfLevel> levels;     // as FastProblem::levels
    ExampleWeights example_weights;  // of the last blend; empty: the rest shape alone
    SupernodalFactor::Workspace factor;
    // Of the solves of a drag. What the next solve begins with is what its draft shows: the solve locks to write.
    std::mutex drafting;
    bool is_drafting = false;  // there is a shape to go on from, and all anchors count in it
    SecantPredictor predictor;
    HandleResponses responses;
    bool keeps_history = false;  // the whole mesh' minimizer: of the last of those, which came to its end
};

}  // namespace meanvalue
