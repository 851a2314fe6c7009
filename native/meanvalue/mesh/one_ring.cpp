#include "meanvalue/mesh/one_ring.h"

#include <algorithm>

#include "meanvalue/mesh/triangle_mesh.h"

namespace meanvalue {
namespace {

const Fan& largest(const std::vector<Fan>& fans) {
    return *std::max_element(fans.begin(), fans.end(),
                             [](const Fan& a, const Fan& b) { return a.ring.size() < b.ring.size(); });
}

RingKind kind_of(const std::vector<Fan>& fans) {
    if (fans.size() > 1) return RingKind::kNonManifold;
    return fans.front().closed ? RingKind::kClosed : RingKind::kOpen;
}

}  // namespace

void OneRings::append(const Index* begin, const Index* end, RingKind kind, bool is_closed) {
    kinds.push_back(kind);
    closed.push_back(is_closed ? 1 : 0);
    vertices.insert(vertices.end(), begin, end);
    offsets.push_back(static_cast<Index>(vertices.size()));
}

OneRings collect_one_rings(Index vertex_count, const TrianglesView& faces, const Execution& execution) {
    const TriangleMesh mesh(vertex_count, faces, execution);
    OneRings rings;
    rings.detached_triangle_count = mesh.detached_count();
    rings.offsets.reserve(vertex_count + 1);
    rings.kinds.reserve(vertex_count);
    rings.closed.reserve(vertex_count);
    rings.vertices.reserve(vertex_count * 6);
    std::vector<Fan> fans;
    for (Index v = 0; v < vertex_count; ++v) {
        execution.check_every(v);
        mesh.collect_fans(v, fans);
        if (fans.empty()) {
            rings.append(nullptr, nullptr, RingKind::kLoose, false);
            continue;
        }
        const Fan& fan = largest(fans);
        rings.append(fan.ring.data(), fan.ring.data() + fan.ring.size(), kind_of(fans), fan.closed);
    }
    return rings;
}

}  // namespace meanvalue
