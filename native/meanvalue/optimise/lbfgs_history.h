// The history of L-BFGS, and the inverse Hessian that it makes of the initial one.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/preconditioner.h"

namespace meanvalue {

/// The last steps of a minimiser and what each changed of the gradient, as pairs. H, the inverse of the
/// initial Hessian updated by them (Nocedal 1980), is applied with products taken from their Gram matrix, so that
/// vectors are read a few times whatever the number of pairs, and in parallel. Pairs are kept in single precision:
/// they are most of what an iteration reads. Deterministic for any number of threads.
class LbfgsHistory {
  public:
    LbfgsHistory() = default;
    /// Pairs at most. Kept from one solve of a drag to the next, so many halve its iterations beside six; more cost
    /// what they save: docs/decisions/0012-predicted-drags.md.
    static constexpr int kPairs = 12;

    /// @param rows of the vectors, |V'|. @param size of the shape: what is kept in single precision is divided by it.
    /// Memory is taken as pairs come.
    LbfgsHistory(Index rows, double size);

    bool empty() const { return order_.empty(); }
    void clear() { order_.clear(); }

    /// direction = -H gradient, both |V'| x 3; H is `scaling` times the preconditioner, updated by the pairs.
    /// @throws Cancelled.
    void find_direction(const Positions& gradient, const Preconditioner& preconditioner, double scaling, int threads,
                        Execution& execution, Positions& direction);

    /// Keeps the step length * direction, which led from `gradient` to `next`, in place of the oldest: unless the
    /// energy does not curve upwards along it by more than rounding, which leaves all as it was. @throws Cancelled.
    void remember(double length, const Positions& direction, const Positions& gradient, const Positions& next,
                  int threads, const Execution& execution);

    /// Once all pairs are in use.

  private:
    /// A step and the change of the gradient that it made: 3 |V'| numbers each, in sizes.
    struct Pair {
        std::vector<float> step;
        std::vector<float> change;
    };

    int free_place() const;

    Index rows_ = 0;
    double size_ = 1.0;
    std::vector<Pair> pairs_;   // one more than may be in use
    std::vector<int> order_;    // of pairs_ in use, the oldest first
    Eigen::MatrixXd products_;  // step of one pair times change of another
    std::vector<double> sums_;  // scratch: one row of partial sums a piece
};

}  // namespace meanvalue
