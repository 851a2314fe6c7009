// The history of L-BFGS, and the inverse Hessian that it makes of a constant matrix.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/fast/history_kernels.h"
#include "meanvalue/solver/supernodal_factor.h"

namespace meanvalue {

/// The last steps of a minimiser and what each changed of the gradient, as pairs. H, the inverse of the constant
/// matrix updated by them (Nocedal 1980), is applied with products taken from their Gram matrix, so that vectors are
/// read a few times whatever the number of pairs, and in parallel. Pairs are kept in single precision: they are most
/// of what an iteration reads. Deterministic for any number of threads.
class LbfgsHistory {
  public:
    LbfgsHistory() = default;
    /// @param rows of the vectors, |V'|. All the memory that is needed is taken here.
    explicit LbfgsHistory(Index rows);

    bool empty() const { return order_.empty(); }
    void clear() { order_.clear(); }

    /// direction = -H gradient, both |V'| x 3. @throws Cancelled.
    void find_direction(const Positions& gradient, SupernodalFactor& factor, int threads, Execution& execution,
                        Positions& direction);

    /// Keeps the step length * direction, which led from `gradient` to `next`, in place of the oldest: unless the
    /// energy does not curve upwards along it by more than rounding. @throws Cancelled.
    void remember(double length, const Positions& direction, const Positions& gradient, const Positions& next,
                  int threads, const Execution& execution);

    std::size_t bytes() const;

  private:
    /// A step and the change of the gradient that it made: 3 |V'| numbers each.
    struct Pair {
        std::vector<float> step;
        std::vector<float> change;
    };

    int free_place();

    HistoryKernels kernels_ = history_kernels();
    Index rows_ = 0;
    std::vector<Pair> pairs_;
    std::vector<int> order_;    // of pairs_ in use, the oldest first
    Eigen::MatrixXd products_;  // step of one pair times change of another
    std::vector<double> sums_;  // scratch: one row of partial sums a piece
};

}  // namespace meanvalue
