#include "meanvalue/linalg/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

// Rows that are corrected at most: their columns take memory, and each step the time to add them.
constexpr std::size_t kMostRows = 256;

}  // namespace

void DiagonalDowndate::set(const SupernodalFactor& factor, const std::vector<Index>& rows,
                           const std::vector<double>& amounts, int threads, const Execution& execution,
                           SupernodalFactor::Workspace& workspace) {
    std::vector<std::size_t> taken(rows.size());
    std::iota(taken.begin(), taken.end(), 0);
    taken.erase(std::remove_if(taken.begin(), taken.end(), [&](std::size_t k) { return !(amounts[k] > 0.0); }),
                taken.end());
    if (taken.size() > kMostRows) {
        std::stable_sort(taken.begin(), taken.end(),
                         [&](std::size_t a, std::size_t b) { return amounts[a] > amounts[b]; });
        taken.resize(kMostRows);
        std::sort(taken.begin(), taken.end());
    }
    std::vector<Index> taken_rows;
    std::vector<double> taken_amounts;
    for (const std::size_t k : taken) {
        taken_rows.push_back(rows[k]);
        taken_amounts.push_back(amounts[k]);
    }
    if (taken_rows == rows_ && taken_amounts == amounts_) return;
    inverse_.resize(0, 0);
    amounts_.clear();
    if (taken_rows != rows_) {
        rows_.clear();
        find_columns(factor, taken_rows, threads, execution, workspace);
        rows_ = std::move(taken_rows);
    }
    Eigen::MatrixXd small = -columns_(rows_, Eigen::all).cast<double>();
    for (std::size_t k = 0; k < rows_.size(); ++k)
        small(k, k) += (1.0 + kSinglePrecision) / taken_amounts[k];
    // Where that has made it indefinite, the factor as it is serves: slower, and to the same minimum.
    const Eigen::LLT<Eigen::MatrixXd> factored(small);
    if (factored.info() == Eigen::Success)
        inverse_ = factored.solve(Eigen::MatrixXd::Identity(small.rows(), small.cols()));
    amounts_ = std::move(taken_amounts);
}

/// Of the inverse, three to a solve.
void DiagonalDowndate::find_columns(const SupernodalFactor& factor, const std::vector<Index>& rows, int threads,
                                    const Execution& execution, SupernodalFactor::Workspace& workspace) {
    const auto count = static_cast<Eigen::Index>(rows.size());
    columns_.resize(factor.size(), count);
    Positions three(factor.size(), 3);
    for (Eigen::Index first = 0; first < count; first += 3) {
        const Eigen::Index taken = std::min<Eigen::Index>(3, count - first);
        three.setZero();
        for (Eigen::Index c = 0; c < taken; ++c)
            three(rows[first + c], c) = 1.0;
        factor.solve(three, three, threads, execution, workspace);
        columns_.middleCols(first, taken) = three.leftCols(taken).cast<float>();
    }
}

void DiagonalDowndate::correct(Positions& solution, int threads, const Execution& execution) const {
    if (inverse_.size() == 0) return;
    const Positions shares = inverse_.lazyProduct(solution(rows_, Eigen::all));
    parallel_for(static_cast<Index>(solution.rows()), threads, execution, [&](Index begin, Index end) {
        for (Index row = begin; row < end; ++row)
            solution.row(row) += columns_.row(row).cast<double>().lazyProduct(shares);
    });
}

}  // namespace meanvalue
