#include "meanvalue/linalg/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "meanvalue/common/grouped.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

// Rows that are corrected at most: their columns take memory, and each step the time to add them.
constexpr std::size_t kMostRows = 256;
constexpr std::size_t kMostBytes = std::size_t{128} << 20;

}  // namespace

void DiagonalDowndate::set(const SupernodalFactor& factor, const std::vector<Index>& rows,
                           const std::vector<double>& amounts, int threads, const Execution& execution,
                           SupernodalFactor::Workspace& workspace) {
    std::vector<std::size_t> taken;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (amounts[k] > 0.0) taken.push_back(k);
    }
    const std::size_t most =
        std::min(kMostRows, kMostBytes / (sizeof(float) * std::max<std::size_t>(factor.size(), 1)));
    if (taken.size() > most) {
        std::stable_sort(taken.begin(), taken.end(),
                         [&](std::size_t a, std::size_t b) { return amounts[a] > amounts[b]; });
        taken.resize(most);
        std::sort(taken.begin(), taken.end());
    }
    std::vector<Index> taken_rows = picked(rows, taken);
    std::vector<double> taken_amounts = picked(amounts, taken);
    if (taken_rows == rows_ && taken_amounts == amounts_) return;
    inverse_.resize(0, 0);
    amounts_.clear();
    rows_.clear();
    find_columns(factor, taken_rows, threads, execution, workspace);
    rows_ = std::move(taken_rows);
    const auto count = static_cast<Eigen::Index>(rows_.size());
    Eigen::MatrixXd small(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        small.col(k) = -columns_.at(rows_[k])(rows_).cast<double>();
        small(k, k) += (1.0 + kSinglePrecision) / taken_amounts[k];
    }
    // By columns and not by LLT: that is made of Eigen's products of matrices, which every processor sums otherwise.
    // Where it has become indefinite, the factor as it is serves: slower, and to the same minimum.
    const Eigen::LDLT<Eigen::MatrixXd> factored(small);
    if (factored.info() == Eigen::Success && factored.isPositive()) {
        inverse_.resize(count, count);
        for (Eigen::Index k = 0; k < count; ++k)
            inverse_.col(k) = factored.solve(Eigen::VectorXd::Unit(count, k));
    }
    amounts_ = std::move(taken_amounts);
}

/// Of the inverse, three to a solve; those that are known already are kept.
void DiagonalDowndate::find_columns(const SupernodalFactor& factor, const std::vector<Index>& rows, int threads,
                                    const Execution& execution, SupernodalFactor::Workspace& workspace) {
    std::map<Index, Eigen::VectorXf> kept;
    std::vector<Index> missing;
    for (const Index row : rows) {
        if (!kept.insert(columns_.extract(row)).inserted) missing.push_back(row);
    }
    columns_.swap(kept);
    Positions three(factor.size(), 3);
    for (std::size_t first = 0; first < missing.size(); first += 3) {
        const std::size_t count = std::min<std::size_t>(3, missing.size() - first);
        three.setZero();
        for (std::size_t c = 0; c < count; ++c)
            three(missing[first + c], static_cast<Eigen::Index>(c)) = 1.0;
        factor.solve(three, three, threads, execution, workspace);
        for (std::size_t c = 0; c < count; ++c)
            columns_.emplace(missing[first + c], three.col(static_cast<Eigen::Index>(c)).cast<float>());
    }
}

void DiagonalDowndate::correct(Positions& solution, int threads, const Execution& execution) const {
    if (inverse_.size() == 0) return;
    const Positions shares = inverse_.lazyProduct(solution(rows_, Eigen::all));
    std::vector<const float*> columns;
    columns.reserve(rows_.size());
    for (const Index row : rows_)
        columns.push_back(columns_.at(row).data());
    parallel_for(static_cast<Index>(solution.rows()), threads, execution, [&](Index begin, Index end) {
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const Eigen::RowVector3d share = shares.row(static_cast<Eigen::Index>(k));
            for (Index row = begin; row < end; ++row)
                solution.row(row) += static_cast<double>(columns[k][row]) * share;
        }
    });
}

}  // namespace meanvalue
