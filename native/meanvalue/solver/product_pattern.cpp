#include "meanvalue/solver/product_pattern.h"

#include <algorithm>

#include "meanvalue/common/errors.h"

namespace meanvalue {
namespace {

// A row of m terms makes m^2 / 2 pairs. Short rows share most of their blocks with their neighbours; those of a long
// one are its own, each 144 bytes here, as much again in the copy to factor, and half as much in the factor. Either
// limit is some 10 GB.
constexpr std::int64_t kMostPairs = 100'000'000;
constexpr std::int64_t kLongRow = 100;
constexpr std::int64_t kMostLongPairs = 25'000'000;

void require_room(const std::vector<std::int64_t>& term_offsets) {
    const auto require = [](std::int64_t pair_count, std::int64_t most) {
        if (pair_count <= most) return;
        throw InvalidInput(message("the rings of the free vertices are too long for this method: they make ",
                                   pair_count, " pairs, and ", most, " fit into memory; split the vertices of ",
                                   "highest valence, or restrict the region of influence"));
    };
    std::int64_t pair_count = 0;
    std::int64_t long_pair_count = 0;
    for (std::size_t row = 0; row + 1 < term_offsets.size(); ++row) {
        const std::int64_t terms = term_offsets[row + 1] - term_offsets[row];
        pair_count += terms * (terms + 1) / 2;
        if (terms > kLongRow) long_pair_count += terms * (terms + 1) / 2;
    }
    require(long_pair_count, kMostLongPairs);
    require(pair_count, kMostPairs);
}

}  // namespace

std::vector<std::vector<Index>> product_pattern(const std::vector<std::int64_t>& term_offsets,
                                                const std::vector<Index>& term_columns, Index column_count,
                                                const Execution& execution) {
    require_room(term_offsets);
    WorkMeter work(execution);
    std::vector<std::vector<Index>> columns(column_count);
    for (Index k = 0; k < column_count; ++k) {
        work.add(1);
        columns[k].push_back(k);
    }
    for (std::size_t row = 0; row + 1 < term_offsets.size(); ++row) {
        for (std::int64_t a = term_offsets[row]; a < term_offsets[row + 1]; ++a) {
            work.add(term_offsets[row + 1] - term_offsets[row]);
            for (std::int64_t b = term_offsets[row]; b < term_offsets[row + 1]; ++b) {
                if (term_columns[a] > term_columns[b]) columns[term_columns[b]].push_back(term_columns[a]);
            }
        }
    }
    for (std::vector<Index>& column : columns) {
        work.add(8 * column.size());
        std::sort(column.begin(), column.end());
        column.erase(std::unique(column.begin(), column.end()), column.end());
    }
    return columns;
}

}  // namespace meanvalue
