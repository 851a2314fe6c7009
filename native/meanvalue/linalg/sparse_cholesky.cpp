#include "meanvalue/linalg/sparse_cholesky.h"

#include <algorithm>
#include <new>
#include <vector>

#include "meanvalue/common/errors.h"
#include "meanvalue/linalg/multifrontal.h"

namespace meanvalue {
namespace {

/// a . b in four sums, in which it goes through the processor's registers of any length.
double dot(const double* a, const double* b, Index count) {
    double sums[4] = {};
    Index k = 0;
    for (; k + 4 <= count; k += 4) {
        for (Index lane = 0; lane < 4; ++lane)
            sums[lane] += a[k + lane] * b[k + lane];
    }
    for (Index lane = 0; k < count; ++k, ++lane)
        sums[lane] += a[k] * b[k];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// Both substitutions, one supernode after another.
class Substitution {
  public:
    Substitution(const SupernodalPattern& pattern, const std::vector<std::int64_t>& first_value, const double* values)
        : pattern_(pattern), first_value_(first_value), values_(values) {}

    /// @param x in the order of the factor, one right-hand side a column.
    void solve(Eigen::MatrixXd& x, const Execution& execution) {
        for (Index s = 0; s < pattern_.count(); ++s) {
            execution.check();
            forward(s, x);
        }
        for (Index s = pattern_.count() - 1; s >= 0; --s) {
            execution.check();
            backward(s, x);
        }
    }

  private:
    void forward(Index s, Eigen::MatrixXd& x) {
        const Index width = pattern_.width(s);
        const Index row_count = pattern_.row_count(s);
        const Index* const rows = pattern_.rows_of(s);
        local_.assign(row_count, 0.0);
        for (Eigen::Index side = 0; side < x.cols(); ++side) {
            double* const of_side = x.col(side).data();
            std::copy_n(of_side + pattern_.first_column[s], width, local_.begin());
            std::fill(local_.begin() + width, local_.end(), 0.0);
            double* const local = local_.data();
            const double* column = values_ + first_value_[s];
            for (Index c = 0; c < width; ++c, column += row_count) {
                const double known = local[c] /= column[c];
                for (Index r = c + 1; r < row_count; ++r)
                    local[r] -= column[r] * known;
            }
            std::copy_n(local, width, of_side + pattern_.first_column[s]);
            for (Index r = width; r < row_count; ++r)
                of_side[rows[r]] += local[r];
        }
    }

    void backward(Index s, Eigen::MatrixXd& x) {
        const Index width = pattern_.width(s);
        const Index row_count = pattern_.row_count(s);
        const Index* const rows = pattern_.rows_of(s);
        local_.resize(row_count);
        for (Eigen::Index side = 0; side < x.cols(); ++side) {
            double* const of_side = x.col(side).data();
            for (Index r = 0; r < row_count; ++r)
                local_[r] = of_side[rows[r]];
            const double* column = values_ + first_value_[s] + pattern_.panel_size(s);
            for (Index c = width - 1; c >= 0; --c) {
                column -= row_count;
                const Index below = c + 1;
                local_[c] -= dot(column + below, local_.data() + below, row_count - below);
                local_[c] /= column[c];
            }
            std::copy_n(local_.begin(), width, of_side + pattern_.first_column[s]);
        }
    }

    const SupernodalPattern& pattern_;
    const std::vector<std::int64_t>& first_value_;
    const double* values_;
    std::vector<double> local_;  // the rows of a supernode
};

/// The panel by columns, each with all rows of the front; what is above the diagonal is not written.
void copy_columns(const FrontShape& shape, const double* panel, double* to, const Execution& execution) {
    const Index row_count = shape.width + shape.below;
    WorkMeter work(execution);
    for (Index c = 0; c < shape.width; ++c, to += row_count) {
        work.add(row_count);
        for (Index row = c; row < row_count;) {
            const Index part_end = row < shape.width ? shape.width : row_count;
            const Index in_part = row < shape.width ? row : row - shape.width;
            const Index count = std::min(kBlockRows - in_part % kBlockRows, part_end - row);
            std::copy_n(panel + shape.place(row) + std::int64_t{c} * kBlockRows, count, to + row);
            row += count;
        }
    }
}

}  // namespace

void throw_too_large(const SparseMatrix& lower, const char* action) {
    throw SolverFailure(message("too little memory to ", action, " a linear system of ", lower.rows(),
                                " unknowns with ", lower.nonZeros(), " entries; restrict the region of influence"));
}

void SparseCholesky::analyse(const SparseMatrix& lower, const Execution& execution, int threads,
                             const std::vector<Index>& order) {
    analysis_.reset();
    values_.reset();
    try {
        auto analysis = std::make_shared<Analysis>();
        analysis->pattern = find_supernodes(lower, threads, execution, order);
        for (Index s = 0; s < analysis->pattern.count(); ++s)
            analysis->first_value.push_back(analysis->first_value.back() + analysis->pattern.panel_size(s));
        analysis_ = std::move(analysis);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "analyse");
    }
}

SparseCholesky SparseCholesky::of_same_pattern() const {
    SparseCholesky other(instructions_);
    other.analysis_ = analysis_;
    return other;
}

bool SparseCholesky::factorise(const SparseMatrix& lower, const Execution& execution, int threads) {
    try {
        // Without writing to it: a fresh gigabyte takes longer to touch than a cancel may wait.
        if (!values_) values_.reset(new double[analysis_->first_value.back()]);
        const auto keep = [&](Index s, const FrontShape& shape, const double* panel) {
            copy_columns(shape, panel, values_.get() + analysis_->first_value[s], execution);
        };
        return factor_fronts(analysis_->pattern, lower, front_kernels(instructions_), threads, keep, execution);
    } catch (const std::bad_alloc&) {
        throw_too_large(lower, "factor");
    }
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right_hand_sides, const Execution& execution) const {
    const std::vector<Index>& order = pattern().order;
    const Eigen::Index size = right_hand_sides.rows();
    Eigen::MatrixXd x(size, right_hand_sides.cols());
    const auto each_number = [&](const auto& action) {
        for (Eigen::Index side = 0; side < x.cols(); ++side) {
            for (Eigen::Index k = 0; k < size; ++k) {
                execution.check_every(k);
                action(k, side);
            }
        }
    };
    each_number([&](Eigen::Index k, Eigen::Index side) { x(k, side) = right_hand_sides(order[k], side); });
    Substitution(analysis_->pattern, analysis_->first_value, values_.get()).solve(x, execution);
    Eigen::MatrixXd solution(size, x.cols());
    each_number([&](Eigen::Index k, Eigen::Index side) { solution(order[k], side) = x(k, side); });
    return solution;
}

}  // namespace meanvalue
