#include "meanvalue/linalg/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// On the diagonal of the small matrix, as a share of it: what single precision may have taken off.
constexpr double kLeastDiagonal = 1e-5;
// Columns that are kept at most, for their memory and the time that they take.
constexpr std::size_t kMostColumns = 256;
constexpr std::size_t kFewestColumns = 16;
constexpr std::size_t kMostBytes = std::size_t{128} << 20;

std::size_t most_columns(const SupernodalFactor& factor) {
    const std::size_t column = sizeof(float) * std::max<std::size_t>(factor.size(), 1);
    return std::clamp(kMostBytes / column, kFewestColumns, kMostColumns);
}

}  // namespace

void DiagonalDowndate::set(const SupernodalFactor& factor, const std::vector<Index>& rows,
                           const std::vector<double>& amounts, int threads, const Execution& execution,
                           SupernodalFactor::Workspace& workspace) {
    std::vector<std::size_t> taken;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (amounts[k] > 0.0) taken.push_back(k);
    }
    const std::size_t most = most_columns(factor);
    if (taken.size() > most) {
        std::stable_sort(taken.begin(), taken.end(),
                         [&](std::size_t a, std::size_t b) { return amounts[a] > amounts[b]; });
        taken.resize(most);
        std::sort(taken.begin(), taken.end());
    }
    std::vector<Index> given_rows;
    std::vector<double> given_amounts;
    for (const std::size_t k : taken) {
        given_rows.push_back(rows[k]);
        given_amounts.push_back(amounts[k]);
    }
    if (given_rows == rows_ && given_amounts == amounts_) return;
    clear();
    know_columns(factor, given_rows, most, threads, execution, workspace);
    const auto size = static_cast<Eigen::Index>(given_rows.size());
    Eigen::MatrixXd small(size, size);
    for (Eigen::Index a = 0; a < size; ++a) {
        for (Eigen::Index b = 0; b <= a; ++b)
            small(a, b) = -0.5 * (column_of(given_rows[a])[given_rows[b]] + column_of(given_rows[b])[given_rows[a]]);
        small(a, a) += (1.0 + kLeastDiagonal) / given_amounts[a];
    }
    // Where rounding has made it indefinite, the factor as it is serves: slower, and to the same minimum.
    const Eigen::LLT<Eigen::MatrixXd> factored(small);
    if (factored.info() == Eigen::Success) inverse_ = factored.solve(Eigen::MatrixXd::Identity(size, size));
    rows_ = std::move(given_rows);
    amounts_ = std::move(given_amounts);
}

/// Makes the columns of the inverse that are not known yet, three to a solve.
void DiagonalDowndate::know_columns(const SupernodalFactor& factor, const std::vector<Index>& rows, std::size_t most,
                                    int threads, const Execution& execution, SupernodalFactor::Workspace& workspace) {
    std::vector<Index> unknown;
    for (const Index row : rows) {
        if (std::find(known_rows_.begin(), known_rows_.end(), row) == known_rows_.end()) unknown.push_back(row);
    }
    if (known_rows_.size() + unknown.size() > most) {
        known_rows_.clear();
        columns_.clear();
        unknown = rows;
    }
    known_rows_.reserve(known_rows_.size() + unknown.size());
    Positions three(factor.size(), 3);
    for (std::size_t first = 0; first < unknown.size(); first += 3) {
        const std::size_t count = std::min<std::size_t>(3, unknown.size() - first);
        three.setZero();
        for (std::size_t c = 0; c < count; ++c)
            three(unknown[first + c], static_cast<Eigen::Index>(c)) = 1.0;
        factor.solve(three, three, threads, execution, workspace);
        for (std::size_t c = 0; c < count; ++c) {
            std::vector<float> column(three.rows());
            for (Eigen::Index row = 0; row < three.rows(); ++row)
                column[row] = static_cast<float>(three(row, static_cast<Eigen::Index>(c)));
            columns_.push_back(std::move(column));
            known_rows_.push_back(unknown[first + c]);
        }
    }
}

void DiagonalDowndate::clear() {
    rows_.clear();
    amounts_.clear();
    inverse_.resize(0, 0);
}

void DiagonalDowndate::correct(Positions& solution, int threads, const Execution& execution) const {
    if (inverse_.size() == 0) return;
    const auto count = static_cast<Eigen::Index>(rows_.size());
    Positions at_rows(count, 3);
    for (Eigen::Index k = 0; k < count; ++k)
        at_rows.row(k) = solution.row(rows_[k]);
    Positions add = Positions::Zero(count, 3);
    for (Eigen::Index a = 0; a < count; ++a) {
        for (Eigen::Index b = 0; b < count; ++b)
            add.row(a) += inverse_(a, b) * at_rows.row(b);
    }
    std::vector<const float*> columns;
    for (const Index row : rows_)
        columns.push_back(column_of(row).data());
    parallel_for(static_cast<Index>(solution.rows()), threads, execution, [&](Index begin, Index end) {
        for (Eigen::Index k = 0; k < count; ++k) {
            const Eigen::RowVector3d of_column = add.row(k);
            for (Index row = begin; row < end; ++row)
                solution.row(row) += static_cast<double>(columns[k][row]) * of_column;
        }
    });
}

const std::vector<float>& DiagonalDowndate::column_of(Index row) const {
    return columns_[std::find(known_rows_.begin(), known_rows_.end(), row) - known_rows_.begin()];
}

}  // namespace meanvalue
