#include <algorithm>

#include "meanvalue/common/mean_row.h"
#include "meanvalue/hierarchy/coarsening.h"

namespace meanvalue {
namespace {

/// Adds the vertex of `part` with the largest measure(position) that does not stay yet.
template <typename Measure>
Vector3 add_extreme(const std::vector<Index>& part, const PositionsView& positions, const Measure& measure,
                    std::vector<char>& stays) {
    Index best = -1;
    double largest = -1.0;
    for (const Index v : part) {
        if (stays[v]) continue;
        const double value = measure(Vector3(positions.row(v)));
        if (value > largest) {
            largest = value;
            best = v;
        }
    }
    stays[best] = 1;
    return positions.row(best);
}

void choose_extremes(const std::vector<Index>& part, const PositionsView& positions, std::vector<char>& stays) {
    if (part.size() <= 4) {
        for (const Index v : part)
            stays[v] = 1;
        return;
    }
    const Vector3 middle = mean_row(positions(part, Eigen::all));
    const auto from = [](const Vector3& place) {
        return [&place](const Vector3& p) { return (p - place).squaredNorm(); };
    };
    const Vector3 first = add_extreme(part, positions, from(middle), stays);
    const Vector3 second = add_extreme(part, positions, from(first), stays);
    const Vector3 axis = second - first;
    const Vector3 third = add_extreme(
        part, positions, [&](const Vector3& p) { return axis.cross(p - first).squaredNorm(); }, stays);
    const auto from_nearest = [&](const Vector3& p) {
        return std::min({(p - first).squaredNorm(), (p - second).squaredNorm(), (p - third).squaredNorm()});
    };
    add_extreme(part, positions, from_nearest, stays);
}

}  // namespace

RemovalRules find_removal_rules(const OneRings& rings, const PositionsView& positions,
                                const std::vector<char>& is_fixed, const CoarseningOptions& options) {
    RemovalRules rules;
    rules.part.assign(is_fixed.size(), -1);
    rules.stays.assign(is_fixed.size(), 0);
    const auto is_soft = [&](Index v) { return !options.is_soft.empty() && options.is_soft[v] != 0; };
    const auto handle_of = [&](Index v) { return options.handles.empty() ? 0 : options.handles[v]; };
    const auto are_alike = [&](Index a, Index b) {
        return is_fixed[a] == is_fixed[b] && is_soft(a) == is_soft(b) && handle_of(a) == handle_of(b);
    };
    Index count = 0;
    std::vector<Index> members;
    for (Index seed = 0; seed < rings.vertex_count(); ++seed) {
        if (is_fixed[seed] && !options.thin_out_fixed) rules.stays[seed] = 1;
        const bool is_of_part = is_soft(seed) || (is_fixed[seed] && options.thin_out_fixed);
        if (!is_of_part || rules.part[seed] >= 0) continue;
        members.assign(1, seed);
        rules.part[seed] = count;
        for (std::size_t k = 0; k < members.size(); ++k) {
            for (const Index* j = rings.begin(members[k]); j != rings.end(members[k]); ++j) {
                if (rules.part[*j] >= 0 || !are_alike(*j, seed)) continue;
                rules.part[*j] = count;
                members.push_back(*j);
            }
        }
        choose_extremes(members, positions, rules.stays);
        ++count;
    }
    return rules;
}

}  // namespace meanvalue
