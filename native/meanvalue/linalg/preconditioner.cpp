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
constexpr std::size_t kMostBytes = std::size_t{128} << 20;

}  // namespace

void DiagonalDowndate::set(const SupernodalFactor& factor, const std::vector<SpringEnd>& ends,
                           const std::vector<double>& amounts, int threads, const Execution& execution,
                           SupernodalFactor::Workspace& workspace) {
    std::vector<std::size_t> taken(ends.size());
    std::iota(taken.begin(), taken.end(), 0);
    taken.erase(std::remove_if(taken.begin(), taken.end(), [&](std::size_t k) { return !(amounts[k] > 0.0); }),
                taken.end());
    const std::size_t most =
        std::min(kMostRows, kMostBytes / (sizeof(float) * std::max<std::size_t>(factor.size(), 1)));
    if (taken.size() > most) {
        std::stable_sort(taken.begin(), taken.end(),
                         [&](std::size_t a, std::size_t b) { return amounts[a] > amounts[b]; });
        taken.resize(most);
        std::sort(taken.begin(), taken.end());
    }
    std::vector<Index> numbers;
    std::vector<double> taken_amounts;
    for (const std::size_t k : taken) {
        numbers.push_back(static_cast<Index>(k));
        taken_amounts.push_back(amounts[k]);
    }
    if (numbers == taken_ && taken_amounts == amounts_) return;
    inverse_.resize(0, 0);
    amounts_.clear();
    taken_.clear();
    ends_.clear();
    find_columns(factor, ends, numbers, threads, execution, workspace);
    taken_ = std::move(numbers);
    for (const Index k : taken_)
        ends_.push_back(ends[k]);
    const auto count = static_cast<Eigen::Index>(taken_.size());
    Eigen::MatrixXd small(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        for (Eigen::Index other = 0; other < count; ++other)
            small(other, k) = -ends_[other].in(columns_.at(taken_[k]));
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
void DiagonalDowndate::find_columns(const SupernodalFactor& factor, const std::vector<SpringEnd>& ends,
                                    const std::vector<Index>& taken, int threads, const Execution& execution,
                                    SupernodalFactor::Workspace& workspace) {
    std::map<Index, Eigen::VectorXf> kept;
    std::vector<Index> missing;
    for (const Index k : taken) {
        if (!kept.insert(columns_.extract(k)).inserted) missing.push_back(k);
    }
    columns_.swap(kept);
    Positions three(factor.size(), 3);
    for (std::size_t first = 0; first < missing.size(); first += 3) {
        const std::size_t count = std::min<std::size_t>(3, missing.size() - first);
        three.setZero();
        for (std::size_t c = 0; c < count; ++c) {
            const SpringEnd& end = ends[missing[first + c]];
            for (std::size_t k = 0; k < end.rows.size(); ++k)
                three(end.rows[k], static_cast<Eigen::Index>(c)) += end.shares[k];
        }
        factor.solve(three, three, threads, execution, workspace);
        for (std::size_t c = 0; c < count; ++c)
            columns_.emplace(missing[first + c], three.col(static_cast<Eigen::Index>(c)).cast<float>());
    }
}

void DiagonalDowndate::correct(Positions& solution, int threads, const Execution& execution) const {
    if (inverse_.size() == 0) return;
    Positions at_ends = Positions::Zero(inverse_.rows(), 3);
    std::vector<const float*> columns;
    for (std::size_t k = 0; k < taken_.size(); ++k) {
        for (std::size_t end = 0; end < ends_[k].rows.size(); ++end)
            at_ends.row(static_cast<Eigen::Index>(k)) += ends_[k].shares[end] * solution.row(ends_[k].rows[end]);
        columns.push_back(columns_.at(taken_[k]).data());
    }
    const Positions shares = inverse_.lazyProduct(at_ends);
    parallel_for(static_cast<Index>(solution.rows()), threads, execution, [&](Index begin, Index end) {
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const Eigen::RowVector3d share = shares.row(static_cast<Eigen::Index>(k));
            for (Index row = begin; row < end; ++row)
                solution.row(row) += static_cast<double>(columns[k][row]) * share;
        }
    });
}

}  // namespace meanvalue
