// L-BFGS whose initial Hessian is factored once.
#pragma once

#include <functional>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/optimise/lbfgs_history.h"
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
