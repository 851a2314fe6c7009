#include <algorithm>
#include <cmath>
#include <numeric>

#include "meanvalue/common/parallel.h"
#include "meanvalue/decode/fast/energy_blocks.h"
#include "meanvalue/encoding/predictor.h"

namespace meanvalue {
namespace {

// Rings with a smaller sum of norms, see hessian_springs(), have no springs; what is above counts by the share,
// since the bound is generous: signs differ. docs/decisions/0011-constant-matrix.md.
constexpr double kLeastStiffness = 0.4;
constexpr double kShareOfBound = 0.3;
// A sum counts as no more than this: the factor in single precision must still resolve what such springs leave free.
constexpr double kMostStiffness = 100.0;

}  // namespace

/// Next to sharp tips and in slivers the ring's normal rotates, or lengths change, with every small move. The initial
/// Hessian knows the weights alone, (I - W), and some dozen such rows in a model would shorten every step of the
/// whole. With N_k = dF_i/dv_k - w_k I, which sum to zero, |sum_k N_k (u_k - u_i)|^2 <= (sum_k |N_k|) sum_k |N_k|
/// |u_k - u_i|^2: as many springs along the spokes. Rows with a small sum have none: they would only resist rotation.
std::vector<HessianSpring> hessian_springs(const Encoding& encoding, const Unknowns& unknowns, const RestCells& cells,
                                           const std::vector<double>& bending, int threads,
                                           const Execution& execution) {
    const auto count = static_cast<Index>(unknowns.rows.size());
    std::vector<std::vector<HessianSpring>> of_pieces(piece_count(count));
    parallel_pieces(count, threads, execution, [&](Index piece, Index begin, Index end) {
        std::vector<Matrix3> blocks;
        std::vector<Index> numbers;
        for (Index row = begin; row < end; ++row) {
            EncodedRing ring = encoding.ring_of(unknowns.rows[row]);
            const Vector3* const edges = cells.edges.data() + encoding.ring_offsets[unknowns.rows[row]];
            Positions around(ring.valence, 3);  // the vertex: its ring
            for (Index k = 0; k < ring.valence; ++k)
                around.row(k) = -edges[k];
            numbers.resize(ring.valence);
            std::iota(numbers.begin(), numbers.end(), 0);
            ring.ring = numbers.data();
            blocks.resize(ring.valence);
            predict_with_jacobian(ring, around, blocks.data());
            double sum = 0.0;
            for (Index k = 0; k < ring.valence; ++k) {
                blocks[k] -= ring.weights[k] * Matrix3::Identity();
                sum += blocks[k].norm();
            }
            if (!(sum > kLeastStiffness) || !std::isfinite(sum)) continue;
            const double counted = std::min(sum, kMostStiffness);
            const double excess = (counted - kLeastStiffness * kLeastStiffness / counted) * counted / sum;
            for (Index k = 0; k < ring.valence; ++k)
                of_pieces[piece].push_back({row, k, kShareOfBound * bending[row] * excess * blocks[k].norm()});
        }
    });
    std::vector<HessianSpring> springs;
    for (const std::vector<HessianSpring>& of_piece : of_pieces)
        springs.insert(springs.end(), of_piece.begin(), of_piece.end());
    return springs;
}

}  // namespace meanvalue
