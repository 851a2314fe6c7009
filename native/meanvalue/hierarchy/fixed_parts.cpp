#include "meanvalue/hierarchy/fixed_parts.h"

#include <algorithm>

namespace meanvalue {
namespace {

/// Adds the vertex of `part` with the largest measure(position) that is not extreme yet.
template <typename Measure>
Vector3 add_extreme(const std::vector<Index>& part, const PositionsView& positions, const Measure& measure,
                    std::vector<char>& is_extreme) {
    Index best = -1;
    double largest = -1.0;
    for (const Index v : part) {
        if (is_extreme[v]) continue;
        const double value = measure(Vector3(positions.row(v)));
        if (value > largest) {
            largest = value;
            best = v;
        }
    }
    is_extreme[best] = 1;
    return positions.row(best);
}

void choose_extremes(const std::vector<Index>& part, const PositionsView& positions, std::vector<char>& is_extreme) {
    if (part.size() <= 4) {
        for (const Index v : part)
            is_extreme[v] = 1;
        return;
    }
    Vector3 middle = Vector3::Zero();
    for (const Index v : part)
        middle += Vector3(positions.row(v));
    middle /= static_cast<double>(part.size());
    const auto from = [](const Vector3& place) {
        return [&place](const Vector3& p) { return (p - place).squaredNorm(); };
    };
    const Vector3 first = add_extreme(part, positions, from(middle), is_extreme);
    const Vector3 second = add_extreme(part, positions, from(first), is_extreme);
    const Vector3 axis = second - first;
    const Vector3 third = add_extreme(
        part, positions, [&](const Vector3& p) { return axis.cross(p - first).squaredNorm(); }, is_extreme);
    const auto from_nearest = [&](const Vector3& p) {
        return std::min({(p - first).squaredNorm(), (p - second).squaredNorm(), (p - third).squaredNorm()});
    };
    add_extreme(part, positions, from_nearest, is_extreme);
}

}  // namespace

FixedParts find_fixed_parts(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                            const std::vector<Index>& handles) {
    FixedParts parts;
    parts.part.assign(is_fixed.size(), -1);
    parts.is_extreme.assign(is_fixed.size(), 0);
    const auto handle_of = [&](Index v) { return handles.empty() ? 0 : handles[v]; };
    Index count = 0;
    std::vector<Index> members;
    for (Index seed = 0; seed < rings.vertex_count(); ++seed) {
        if (!is_fixed[seed] || parts.part[seed] >= 0) continue;
        members.assign(1, seed);
        parts.part[seed] = count;
        for (std::size_t k = 0; k < members.size(); ++k) {
            for (const Index* j = rings.begin(members[k]); j != rings.end(members[k]); ++j) {
                if (!is_fixed[*j] || parts.part[*j] >= 0 || handle_of(*j) != handle_of(seed)) continue;
                parts.part[*j] = count;
                members.push_back(*j);
            }
        }
        choose_extremes(members, positions, parts.is_extreme);
        ++count;
    }
    return parts;
}

}  // namespace meanvalue
