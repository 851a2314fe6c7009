#include "meanvalue/paper/block_matrix.h"

#include <algorithm>

namespace meanvalue {
namespace {

// Entries written between two checks for cancellation: some milliseconds, even where memory is touched first.
constexpr std::int64_t kEntriesPerCheck = 1 << 20;

}  // namespace

BlockMatrix::BlockMatrix(const std::vector<std::vector<Index>>& columns, const Execution& execution) {
    for (const std::vector<Index>& column : columns) {
        execution.check_every(block_start_.size());
        block_row_.insert(block_row_.end(), column.begin(), column.end());
        block_start_.push_back(static_cast<std::int64_t>(block_row_.size()));
    }
    take_room(execution);
}

void BlockMatrix::take_room(const Execution& execution) {
    const std::int64_t size = kSize * static_cast<std::int64_t>(block_column_count());
    matrix_.resize(size, size);
    matrix_.resizeNonZeros(kSize * kSize * block_start_.back());
    std::int64_t* outer = matrix_.outerIndexPtr();
    std::int64_t* inner = matrix_.innerIndexPtr();
    for (Index column = 0; column < block_column_count(); ++column) {
        execution.check_every(column);
        for (int c = 0; c < kSize; ++c) {
            *outer++ = inner - matrix_.innerIndexPtr();
            for (std::int64_t position = block_start_[column]; position < block_start_[column + 1]; ++position) {
                for (int r = 0; r < kSize; ++r)
                    *inner++ = kSize * std::int64_t{block_row_[position]} + r;
            }
        }
    }
    *outer = inner - matrix_.innerIndexPtr();
}

BlockMatrix BlockMatrix::with_same_pattern(const Execution& execution) const {
    BlockMatrix result;
    result.block_start_ = block_start_;
    result.block_row_ = block_row_;
    result.take_room(execution);
    return result;
}

std::int64_t BlockMatrix::find(Index row, Index column) const {
    const auto begin = block_row_.begin() + block_start_[column];
    const auto end = block_row_.begin() + block_start_[column + 1];
    return std::lower_bound(begin, end, row) - block_row_.begin();
}

void BlockMatrix::set_zero(const Execution& execution) {
    double* const values = matrix_.valuePtr();
    for (std::int64_t begin = 0; begin < matrix_.nonZeros(); begin += kEntriesPerCheck) {
        execution.check();
        std::fill(values + begin, values + std::min<std::int64_t>(begin + kEntriesPerCheck, matrix_.nonZeros()), 0.0);
    }
}

void BlockMatrix::add_identity_multiples(const std::vector<double>& values, double scale) {
    for (Index column = 0; column < block_column_count(); ++column) {
        for (std::int64_t position = block_start_[column]; position < block_start_[column + 1]; ++position) {
            add(position, column, scale * values[position] * Matrix3::Identity());
        }
    }
}

void BlockMatrix::add_to_diagonal(double amount) {
    for (Index column = 0; column < block_column_count(); ++column) {
        add(block_start_[column], column, amount * Matrix3::Identity());
    }
}

}  // namespace meanvalue
