#include "meanvalue/solver/unknowns.h"

#include <algorithm>

namespace meanvalue {

Unknowns find_unknowns(const Encoding& encoding, const std::vector<char>& is_fixed) {
    Unknowns unknowns;
    unknowns.slot.assign(encoding.vertex_count(), -1);
    for (Index v = 0; v < encoding.vertex_count(); ++v) {
        if (is_fixed[v]) continue;
        unknowns.slot[v] = static_cast<Index>(unknowns.free.size());
        unknowns.free.push_back(v);
    }
    for (Index v = 0; v < encoding.vertex_count(); ++v) {
        if (!encoding.predictable(v)) continue;  // its residual is zero whatever happens
        const Index* begin = encoding.ring.data() + encoding.ring_offsets[v];
        const Index* end = encoding.ring.data() + encoding.ring_offsets[v + 1];
        const bool depends =
            unknowns.slot[v] >= 0 || std::any_of(begin, end, [&](Index j) { return unknowns.slot[j] >= 0; });
        if (depends) unknowns.rows.push_back(v);
    }
    return unknowns;
}

}  // namespace meanvalue
