#include "meanvalue/paper/product_pattern.h"

#include <algorithm>

namespace meanvalue {

std::vector<std::vector<Index>> product_pattern(const std::vector<std::int64_t>& term_offsets,
                                                const std::vector<Index>& term_columns, Index column_count,
                                                const Execution& execution) {
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
