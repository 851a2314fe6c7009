#include "meanvalue/decode/fast/hessian_springs.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/encoding/predictor.h"

namespace meanvalue {
namespace {

// Rings with a smaller sum of norms, see find_stiff_rings(), have no springs; what is above counts by the share,
// since the bound is generous: signs differ. docs/decisions/0011-constant-matrix.md.
constexpr double kLeastStiffness = 0.4;
constexpr double kShareOfBound = 0.3;
// A sum counts as no more than this: the factor in single precision must still resolve what such springs leave free.
constexpr double kMostStiffness = 100.0;

}  // namespace

/// Next to sharp tips and in slivers the
/// ring's normal rotates, or lengths change, with every small move. The initial Hessian knows the weights alone,
/// (I - W), and some dozen such rows in a model would shorten every step of the whole. With N_k = dF_i/dv_k - w_k I,
/// which sum to zero, |sum_k N_k (u_k - u_i)|^2 <= (sum_k |N_k|) sum_k |N_k| |u_k - u_i|^2: as many springs along the
/// spokes. Rows with a small sum have none: they would only resist rotation.
StiffRings find_stiff_rings(const Encoding& encoding, const std::vector<Index>& vertices, const RestCells& cells,
                            const Execution& execution) {
    StiffRings stiff;
    std::vector<Matrix3> blocks;
    std::vector<double> norms;
    std::vector<Index> numbers;
    Positions around;  // the vertex: its ring
    for (std::size_t row = 0; row < vertices.size(); ++row) {
        execution.check_every(row);
        EncodedRing ring = encoding.ring_of(vertices[row]);
        blocks.resize(ring.valence);
        norms.resize(ring.valence);
        const Vector3* const edges = cells.edges.data() + encoding.ring_offsets[vertices[row]];
        if (around.rows() < ring.valence) around.resize(ring.valence, 3);
        for (Index k = 0; k < ring.valence; ++k)
            around.row(k) = -edges[k];
        while (numbers.size() < static_cast<std::size_t>(ring.valence))
            numbers.push_back(static_cast<Index>(numbers.size()));
        ring.ring = numbers.data();
        predict_with_jacobian(ring, around, blocks.data());
        double sum = 0.0;
        for (Index k = 0; k < ring.valence; ++k) {
            norms[k] = (blocks[k] - ring.weights[k] * Matrix3::Identity()).norm();
            sum += norms[k];
        }
        if (!(sum > kLeastStiffness) || !std::isfinite(sum)) continue;
        const double counted = std::min(sum, kMostStiffness);
        const double excess = (counted - kLeastStiffness * kLeastStiffness / counted) * counted / sum;
        stiff.rings.push_back({vertices[row], excess, static_cast<std::int64_t>(stiff.norms.size())});
        stiff.norms.insert(stiff.norms.end(), norms.begin(), norms.end());
    }
    return stiff;
}

std::vector<HessianSpring> hessian_springs(const StiffRings& rings, const Encoding& encoding,
                                           const Unknowns& unknowns, const std::vector<double>& bending) {
    std::vector<HessianSpring> spokes;
    std::size_t row = 0;  // both are in the order of vertices
    for (const StiffRings::Ring& ring : rings.rings) {
        while (row < unknowns.rows.size() && unknowns.rows[row] < ring.vertex)
            ++row;
        if (row == unknowns.rows.size()) break;
        if (unknowns.rows[row] != ring.vertex) continue;
        const Index valence = encoding.ring_of(ring.vertex).valence;
        for (Index k = 0; k < valence; ++k)
            spokes.push_back({static_cast<Index>(row), k,
                              kShareOfBound * bending[row] * ring.excess * rings.norms[ring.first_norm + k]});
    }
    return spokes;
}

}  // namespace meanvalue
