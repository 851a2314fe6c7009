// Decoding of one vertex from its ring: paper, equations 10 to 14, and the derivative that section 3.2.2 needs.
#pragma once

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"

namespace meanvalue {

/// [v]_x: cross_matrix(v) * x = v x x.
inline Matrix3 cross_matrix(const Vector3& v) {
    Matrix3 matrix;
    matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    return matrix;
}

/// F_i(V), equation 13, in time linear in the valence. Equivariant under similarities of V.
/// The normal is softened where the ring has folded up (SoftNormal), so that the result is smooth and always finite
/// for finite positions.
/// @param positions n x 3, at least as far as the ring reaches; @param ring of a predictable vertex.
Vector3 predict(const EncodedRing& ring, const PositionsView& positions);

/// F_i(V) and dF_i/dv_k for every ring vertex k, in closed form (docs/algorithm.md, "Derivative of F").
/// Exact wherever F is differentiable; at a projected neighbor that coincides with the projected vertex,
/// a subgradient.
/// @param blocks receives `ring.valence` 3 x 3 matrices.
Vector3 predict_with_jacobian(const EncodedRing& ring, const PositionsView& positions, Matrix3* blocks);

/// F_i(V) for every vertex; v_i itself where a vertex is not predictable.
/// @return n x 3. @throws Cancelled.
Positions predict_all(const Encoding& encoding, const PositionsView& positions, int threads,
                      const Execution& execution);

/// G, equation 15, over all vertices, in squared units of the input.
/// @throws Cancelled.
double energy(const Encoding& encoding, const PositionsView& positions, int threads, const Execution& execution);

}  // namespace meanvalue
