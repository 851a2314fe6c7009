#include "meanvalue/morph/unwrap_rotations.h"

#include <algorithm>
#include <numeric>
#include <queue>

#include "meanvalue/morph/rotation_vectors.h"

namespace meanvalue {

std::vector<Vector3> unwrap_rotations(const Encoding& layout, const std::vector<Matrix3>& rotations,
                                      Index shape_count, const Execution& execution) {
    const auto count = static_cast<std::size_t>(shape_count);
    const Index vertices = layout.vertex_count();
    const auto rotation = [&](Index v, std::size_t k) -> const Matrix3& { return rotations[v * count + k]; };
    std::vector<Vector3> vectors(rotations.size(), Vector3::Zero());
    std::vector<double> rotated(vertices, 0.0);
    for (Index v = 0; v < vertices; ++v) {
        for (std::size_t k = 0; k < count; ++k)
            rotated[v] = std::max(rotated[v], 3.0 - rotation(v, k).trace());
    }
    std::vector<Index> starts(vertices);
    std::iota(starts.begin(), starts.end(), 0);
    std::stable_sort(starts.begin(), starts.end(), [&](Index a, Index b) { return rotated[a] < rotated[b]; });

    struct Step {
        double cost;
        Index from;
        Index to;
        bool operator>(const Step& other) const {
            return cost != other.cost ? cost > other.cost : to != other.to ? to > other.to : from > other.from;
        }
    };
    std::vector<char> is_known(vertices, 0);
    std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
    const auto settle = [&](Index v, Index from) {
        is_known[v] = 1;
        for (std::size_t k = 0; k < count; ++k)
            vectors[v * count + k] = rotation_vector(rotation(v, k), vectors[from * count + k]);
        for (Index place = layout.ring_offsets[v]; place < layout.ring_offsets[v + 1]; ++place) {
            const Index next = layout.ring[place];
            if (is_known[next]) continue;
            double cost = 0.0;
            for (std::size_t k = 0; k < count; ++k)
                cost = std::max(cost, 3.0 - rotation(v, k).cwiseProduct(rotation(next, k)).sum());
            queue.push({cost, v, next});
        }
    };
    for (std::size_t number = 0; number < starts.size(); ++number) {
        execution.check_every(number);
        if (is_known[starts[number]]) continue;
        settle(starts[number], starts[number]);
        for (std::size_t round = 0; !queue.empty(); ++round) {
            execution.check_every(round);
            const Step step = queue.top();
            queue.pop();
            if (!is_known[step.to]) settle(step.to, step.from);
        }
    }
    return vectors;
}

}  // namespace meanvalue
