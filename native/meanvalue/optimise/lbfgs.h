// L-BFGS whose initial Hessian is factored once.
#pragma once

#include <functional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/preconditioner.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// Whether the energy falls by enough of what its slope at the start promises (Armijo).
/// @param promised the length of the step times the slope, below 0. False also for an energy that is not a number.
inline bool falls_enough(double energy, double energy_then, double promised) {
    constexpr double kSufficientDecrease = 1e-4;
    return energy_then < energy && energy_then <= energy + kSufficientDecrease * promised;
}

struct LbfgsOptions {
    /// Stop when no vertex has moved farther in two steps in a row, or with patience far less in one; in the units
    /// of the positions.
    double step_tolerance = 0.0;
    /// If above 0: also stop where steps are nearly so short and some iterations together lower the energy by less
    /// than this share of it; and not where it still falls faster, unless steps are far shorter with patience.
    double energy_tolerance = 0.0;
    /// The iterations before the energy tolerance counts. With patience no step is lengthened.
    int patience = 0;
    int max_iterations = 100;
    double enough_energy = 0.0;  ///< also stop where it is not above this
    int threads = 1;
    /// Begin with the history of the last call: of the same factor, and near where that ended.
    bool keep_history = false;
};

struct LbfgsReport {
    std::vector<double> energies;   ///< at the start and after each iteration; never rises
    double initial_gradient = 0.0;  ///< norm of dE/dV' at the start
    double gradient = 0.0;          ///< and at the end
    bool converged = false;
    bool at_limit = false;  ///< of iterations
    // If neither is set, no step lowers the energy further.

    int iterations() const { return static_cast<int>(energies.size()) - 1; }
};

/// The last steps of a minimizer and what each changed of the gradient, as pairs. H, the inverse of the
/// initial Hessian updated by them, is applied by the two loops of Nocedal (1980). Pairs are kept in single
/// precision: they are most of what an iteration reads. Deterministic for any number of threads.
class LbfgsHistory {
  public:
    LbfgsHistory() = default;
    /// Pairs at most. Kept from one solve of a drag to the next, so many halve its iterations beside six; more cost
    /// what they save: docs/decisions/0012-predicted-drags.md.
    static constexpr int kPairs = 12;

    /// @param rows of the vectors, |V'|. @param size of the shape: what is kept in single precision is divided by it.
    /// Memory is taken as pairs come.
    LbfgsHistory(Index rows, double size) : rows_(rows), size_(size) {}

    bool empty() const { return pairs_.empty(); }
    void clear() { pairs_.clear(); }

    /// direction = -H gradient, both |V'| x 3; H is the preconditioner, updated by the pairs.
    /// @throws Cancelled.
    void find_direction(const Positions& gradient, const Preconditioner& preconditioner, int threads,
                        const Execution& execution, Positions& direction) const;

    /// Keeps the step length * direction, which led from `gradient` to `next`, in place of the oldest: unless the
    /// energy does not curve upwards along it by more than rounding, which leaves all as it was. @throws Cancelled.
    void remember(double length, const Positions& direction, const Positions& gradient, const Positions& next,
                  int threads, const Execution& execution);

  private:
    /// A step and the change of the gradient that it made: 3 |V'| numbers each, in sizes.
    struct Pair {
        std::vector<float> step;
        std::vector<float> change;
        double curvature = 0.0;  // their product
    };

    Index rows_ = 0;
    double size_ = 1.0;
    std::vector<Pair> pairs_;  // the oldest first
    Pair next_;                // being made; its memory is that of the last that was dropped
};

/// The minimizer of one set of free vertices; keeps the memory that it needs: one for each solve that runs.
///
/// Each step is -H g, H being the inverse of the initial Hessian updated by the last few steps (LbfgsHistory), and is
/// halved until the energy falls. Deterministic for any number of threads.
class Lbfgs {
  public:
    /// Fills the gradient at the positions, |V'| x 3, and returns the energy.
    using Energy = std::function<double(const Positions& positions, Positions& gradient)>;

    Lbfgs() = default;
    /// @param size of the shape. @pre unknowns outlive it.
    explicit Lbfgs(const Unknowns& unknowns, double size = 1.0);

    /// Moves the free vertices in `positions` (n x 3) down to a minimum of the energy.
    /// @param preconditioner the inverse of a symmetric positive definite matrix near the energy's Hessian, over the
    /// free vertices.
    /// @throws Cancelled, with `positions` at the last step taken; SolverFailure where the start is not finite.
    LbfgsReport minimise(const Energy& energy, const Preconditioner& preconditioner, const LbfgsOptions& options,
                         Positions& positions, Execution& execution);

  private:
    void lengthen(const Energy& energy, int threads, double value, double slope, const Positions& positions,
                  const Execution& execution, double& length, double& trial_value);
    void move_free(double length, const Positions& from, Positions& to, int threads,
                   const Execution& execution) const;

    const Unknowns* unknowns_ = nullptr;
    double size_ = 1.0;
    Positions gradient_, trial_gradient_, farther_gradient_, direction_;  // |V'| x 3
    Positions trial_, farther_;                                           // n x 3
    LbfgsHistory history_;
};

}  // namespace meanvalue
