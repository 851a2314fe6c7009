// The inverse of a factored matrix, also with a part of its diagonal taken off again.
#pragma once

#include <map>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/linalg/supernodal_factor.h"

namespace meanvalue {

/// Corrects what a factor of A solves to what A - E D E^T solves, E a few rows and D positive numbers: springs that
/// were factored and count less for the time being (Sherman, Morrison and Woodbury; Hager 1989). A row costs a third
/// of a solve when it is new, then little: its column of the inverse is kept as long as it counts.
class DiagonalDowndate {
  public:
    /// @param rows of the factored matrix. @param amounts for each row, 0 or more: what is taken off its diagonal,
    /// less than what was put there. Does nothing if both are as before. At most 256 rows count, or as many as have
    /// columns in 128 MB: those with the largest amounts.
    /// @throws Cancelled, and then corrects nothing.
    void set(const SupernodalFactor& factor, const std::vector<Index>& rows, const std::vector<double>& amounts,
             int threads, const Execution& execution, SupernodalFactor::Workspace& workspace);

    /// Turns the solution for A (n x 3) into that for the other matrix. @throws Cancelled.
    void correct(Positions& solution, int threads, const Execution& execution) const;

  private:
    void find_columns(const SupernodalFactor& factor, const std::vector<Index>& rows, int threads,
                      const Execution& execution, SupernodalFactor::Workspace& workspace);

    std::vector<Index> rows_;  // with an amount above 0
    std::vector<double> amounts_;
    std::map<Index, Eigen::VectorXf> columns_;  // of A^-1, by row
    Eigen::MatrixXd inverse_;                   // of D^-1 - E^T A^-1 E; empty: nothing is corrected
};

/// The inverse that steps are made with.
struct Preconditioner {
    const SupernodalFactor& factor;
    SupernodalFactor::Workspace& workspace;
    const DiagonalDowndate* downdate = nullptr;

    /// As SupernodalFactor::solve(), corrected.
    void solve(const PositionsView& right_hand_sides, Positions& solution, int threads,
               const Execution& execution) const {
        factor.solve(right_hand_sides, solution, threads, execution, workspace);
        if (downdate != nullptr) downdate->correct(solution, threads, execution);
    }
};

}  // namespace meanvalue
