// Items by their numbers: those that belong to one, all in one vector; and those of some.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

template <typename Item>
struct Grouped {
    struct Range {
        const Item* first;
        const Item* last;
        const Item* begin() const { return first; }
        const Item* end() const { return last; }
        bool empty() const { return first == last; }
        Index size() const { return static_cast<Index>(last - first); }
    };
    Index size() const { return static_cast<Index>(offsets.size()) - 1; }
    /// The items of a group, in the order in which they came.
    Range of(std::size_t group) const { return {items.data() + offsets[group], items.data() + offsets[group + 1]}; }

    std::vector<std::int64_t> offsets = {0};  ///< of the groups in items, then the total
    std::vector<Item> items;
};

/// @param for_each calls the function that it is given with (group, item) for each item; it is called twice.
template <typename Item, typename ForEach>
Grouped<Item> grouped(std::size_t group_count, const ForEach& for_each) {
    Grouped<Item> result;
    result.offsets.assign(group_count + 1, 0);
    for_each([&](std::size_t group, const Item&) { ++result.offsets[group + 1]; });
    std::partial_sum(result.offsets.begin(), result.offsets.end(), result.offsets.begin());
    result.items.resize(result.offsets.back());
    std::vector<std::int64_t> next(result.offsets.begin(), result.offsets.end() - 1);
    for_each([&](std::size_t group, const Item& item) { result.items[next[group]++] = item; });
    return result;
}

/// items[numbers[0]], items[numbers[1]], ...
template <typename Item, typename Number>
std::vector<Item> picked(const std::vector<Item>& items, const std::vector<Number>& numbers) {
    std::vector<Item> result;
    result.reserve(numbers.size());
    for (const Number number : numbers)
        result.push_back(items[number]);
    return result;
}

}  // namespace meanvalue
