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

std::vector<char> changed_members(const FixedParts& before, const FixedParts& after, std::size_t vertex_count) {
    const auto part_in = [](const FixedParts& parts, std::size_t v) {
        return parts.part.empty() ? -1 : parts.part[v];
    };
    const auto is_extreme_in = [](const FixedParts& parts, std::size_t v) {
        return !parts.part.empty() && parts.is_extreme[v] != 0;
    };
    constexpr Index kNone = -1;
    constexpr Index kSeveral = -2;
    // What each part is called in the other, if all of its members are of one part there.
    std::vector<Index> before_of(vertex_count, kNone);
    std::vector<Index> after_of(vertex_count, kNone);
    const auto note = [](Index& name, Index other) {
        if (other < 0 || (name != kNone && name != other)) {
            name = kSeveral;
        } else {
            name = other;
        }
    };
    for (std::size_t v = 0; v < vertex_count; ++v) {
        const Index first = part_in(before, v);
        const Index second = part_in(after, v);
        if (first >= 0) note(after_of[first], second);
        if (second >= 0) note(before_of[second], first);
    }
    std::vector<char> changed(vertex_count, 0);
    for (std::size_t v = 0; v < vertex_count; ++v) {
        const Index first = part_in(before, v);
        const Index second = part_in(after, v);
        if (first < 0 && second < 0) continue;
        const bool is_same = first >= 0 && second >= 0 && after_of[first] == second && before_of[second] == first &&
                             is_extreme_in(before, v) == is_extreme_in(after, v);
        changed[v] = is_same ? 0 : 1;
    }
    return changed;
}

}  // namespace meanvalue
