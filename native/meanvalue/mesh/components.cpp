#include "meanvalue/mesh/components.h"

#include "meanvalue/common/tolerances.h"
#include "meanvalue/mesh/disjoint_sets.h"

namespace meanvalue {
namespace {

/// How many of a similarity's seven dimensions the fixed vertices and soft anchors of one part leave open: all seven
/// without any, four if they are in one place, one if they are in one line (the turn about it), else none.
/// @param fixed their numbers.
int undetermined_dimensions(const PositionsView& positions, const std::vector<Index>& fixed) {
    if (fixed.empty()) return 7;
    const Vector3 first = positions.row(fixed.front());
    Vector3 axis = Vector3::Zero();
    for (const Index v : fixed) {
        const Vector3 offset = Vector3(positions.row(v)) - first;
        if (offset.squaredNorm() > axis.squaredNorm()) axis = offset;
    }
    if (axis.squaredNorm() == 0.0) return 4;
    for (const Index v : fixed) {
        const Vector3 offset = Vector3(positions.row(v)) - first;
        if (axis.cross(offset).norm() > kCoincident * axis.squaredNorm()) return 0;
    }
    return 1;
}

}  // namespace

Components find_components(const PositionsView& positions, const TrianglesView& faces,
                           const std::vector<char>& is_fixed, const Execution& execution,
                           const std::vector<char>& is_soft) {
    const Index vertex_count = static_cast<Index>(positions.rows());
    DisjointSets sets(vertex_count);
    for (Index f = 0; f < faces.rows(); ++f) {
        execution.check_every(f);
        sets.join(faces(f, 0), faces(f, 1));
        sets.join(faces(f, 1), faces(f, 2));
    }
    Components result;
    result.part_of.assign(vertex_count, -1);
    execution.check();
    for (Index v = 0; v < vertex_count; ++v) {
        const Index root = sets.root(v);
        if (root == v) {  // a root is the lowest vertex of its set, so it comes first
            result.part_of[v] = static_cast<Index>(result.parts.size());
            result.parts.emplace_back();
            result.parts.back().first_vertex = v;
            result.fixed.emplace_back();
        }
        const Index part = result.part_of[v] = result.part_of[root];
        ++result.parts[part].vertex_count;
        if (is_fixed[v]) {
            ++result.parts[part].fixed_count;
            result.fixed[part].push_back(v);
        } else {
            ++result.parts[part].free_count;
            if (is_soft.empty() || !is_soft[v]) continue;
            ++result.parts[part].soft_count;
            result.fixed[part].push_back(v);
        }
    }
    for (std::size_t part = 0; part < result.parts.size(); ++part) {
        result.parts[part].undetermined = undetermined_dimensions(positions, result.fixed[part]);
    }
    return result;
}

}  // namespace meanvalue
