#include "meanvalue/morph/unwrap_rotations.h"

#include <algorithm>

#include "meanvalue/morph/rotation_vectors.h"
#include "meanvalue/morph/spanning_trees.h"

namespace meanvalue {

std::vector<Vector3> unwrap_rotations(const Encoding& layout, const std::vector<Matrix3>& rotations,
                                      Index shape_count, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count);
    const auto rotation = [&](Index v, std::size_t k) -> const Matrix3& { return rotations[v * count + k]; };
    std::vector<double> angles(layout.vertex_count(), 0.0);
    execution.check();
    for (Index v = 0; v < layout.vertex_count(); ++v) {
        for (std::size_t k = 0; k < count; ++k)
            angles[v] = std::max(angles[v], 3.0 - rotation(v, k).trace());
    }
    const auto edges = [&](Index v, const auto& visit) {
        for (Index place = layout.ring_offsets[v]; place < layout.ring_offsets[v + 1]; ++place) {
            const Index neighbour = layout.ring[place];
            double cost = 0.0;
            for (std::size_t k = 0; k < count; ++k)
                cost = std::max(cost, 3.0 - rotation(v, k).cwiseProduct(rotation(neighbour, k)).sum());
            visit(neighbour, cost, place);
        }
    };
    std::vector<Vector3> vectors(rotations.size(), Vector3::Zero());
    for (const TreeStep& step : spanning_trees(angles, edges, execution)) {
        for (std::size_t k = 0; k < count; ++k)
            vectors[step.node * count + k] = rotation_vector(rotation(step.node, k), vectors[step.from * count + k]);
    }
    return vectors;
}

}  // namespace meanvalue
