#include "meanvalue/linalg/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// On the diagonal of the small matrix, as a share of it: what single precision may have taken off.
constexpr double kLeastDiagonal = 1e-5;
// Beyond so many rows the columns take more memory and time than they save.
constexpr std::size_t kMostRows = 256;

}  // namespace

void DiagonalDowndate::set(const SupernodalFactor& factor, const std::vector<Index>& rows,
                           const std::vector<double>& amounts, int threads, const Execution& execution,
                           SupernodalFactor::Workspace& workspace) {
    std::vector<Index> given_rows;
    std::vector<double> given_amounts;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (!(amounts[k] > 0.0)) continue;
        given_rows.push_back(rows[k]);
        given_amounts.push_back(amounts[k]);
    }
    if (given_rows == rows_ && given_amounts == amounts_) return;
    clear();
    if (given_rows.size() > kMostRows) return;
    std::vector<Index> unknown;
    for (const Index row : given_rows) {
        if (std::find(known_rows_.begin(), known_rows_.end(), row) == known_rows_.end()) unknown.push_back(row);
    }
    if (known_rows_.size() + unknown.size() > kMostRows) {
        known_rows_.clear();
        columns_.clear();
        unknown = given_rows;
    }
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
    const auto size = static_cast<Eigen::Index>(given_rows.size());
    Eigen::MatrixXd small(size, size);
    for (Eigen::Index a = 0; a < size; ++a) {
        for (Eigen::Index b = 0; b <= a; ++b)
            small(a, b) = -0.5 * (column_of(given_rows[a])[given_rows[b]] + column_of(given_rows[b])[given_rows[a]]);
        small(a, a) += (1.0 + kLeastDiagonal) / given_amounts[a];
    }
    const Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> cholesky(small);
    rows_ = std::move(given_rows);
    amounts_ = std::move(given_amounts);
    // Where rounding has made it indefinite, the factor as it is serves: slower, and to the same minimum.
    if (size > 0 && cholesky.info() == Eigen::Success)
        inverse_ = cholesky.solve(Eigen::MatrixXd::Identity(size, size));
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
    const Positions add = inverse_ * at_rows;
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

std::size_t DiagonalDowndate::bytes() const {
    return columns_.empty() ? 0 : columns_.size() * columns_.front().size() * sizeof(float);
}

}  // namespace meanvalue
