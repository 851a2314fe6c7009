#include "meanvalue/optimise/unknowns.h"

#include <algorithm>

namespace meanvalue {

Unknowns find_unknowns(const std::vector<Index>& ring_offsets, const std::vector<Index>& ring,
                       const std::vector<char>& is_fixed) {
    const Index vertex_count = static_cast<Index>(is_fixed.size());
    Unknowns unknowns;
    unknowns.number.assign(vertex_count, -1);
    for (Index v = 0; v < vertex_count; ++v) {
        if (is_fixed[v]) continue;
        unknowns.number[v] = static_cast<Index>(unknowns.free.size());
        unknowns.free.push_back(v);
    }
    for (Index v = 0; v < vertex_count; ++v) {
        const Index* begin = ring.data() + ring_offsets[v];
        const Index* end = ring.data() + ring_offsets[v + 1];
        if (begin == end) continue;  // its residual is zero whatever happens
        const bool depends =
            unknowns.number[v] >= 0 || std::any_of(begin, end, [&](Index j) { return unknowns.number[j] >= 0; });
        if (depends) unknowns.rows.push_back(v);
    }
    return unknowns;
}

Grouped<Use> uses_of(const Encoding& encoding, const Unknowns& unknowns, const Execution& execution) {
    WorkMeter work(execution);
    return grouped<Use>(unknowns.number.size(), [&](const auto& visit) {
        for (std::size_t row = 0; row < unknowns.rows.size(); ++row) {
            const EncodedRing ring = encoding.ring_of(unknowns.rows[row]);
            work.add(1 + ring.valence);
            for (Index k = 0; k < ring.valence; ++k)
                visit(ring.ring[k], {static_cast<Index>(row), k});
        }
    });
}

}  // namespace meanvalue
