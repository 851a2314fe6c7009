// The history of L-BFGS, and the inverse Hessian that it makes of the initial one.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/preconditioner.h"

namespace meanvalue {

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

}  // namespace meanvalue
