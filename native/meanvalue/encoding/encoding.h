// The mean-value encoding of a mesh: what is stored for each half-edge, and which vertices needed a fallback.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// Why a vertex was encoded otherwise than by equations 1 to 9; flags, several may hold.
enum GuardReason : std::uint8_t {
    kOnRingEdge = 1,       ///< projects onto an edge of its ring (a straight boundary does): limit of equation 7
    kOnRingVertex = 2,     ///< projects onto a ring vertex: limit of equation 7
    kLargeWeights = 4,     ///< equation 7 amplified errors too much: least-norm weights instead
    kSteepEdge = 8,        ///< an edge is nearly parallel to the normal: normal offset by its own weights
    kExtendedRing = 16,    ///< the neighbors span no plane: ring taken from farther vertices
    kNonManifold = 32,     ///< several fans of triangles meet here: the largest one is the ring
    kNotPredictable = 64,  ///< nothing around spans a plane, or no triangles at all: F_i(V) = v_i
};

/// One ring and its coefficients, as the predictor reads them. All arrays have `valence` entries.
struct EncodedRing {
    const Index* ring;
    const double* weights;
    const double* heights;
    const double* normal_weights;  ///< nullptr where the height is shared by `weights` (equation 13)
    double softening;              ///< see SoftNormal
    Index valence;
};

/// Invariant under rotation, translation and uniform scaling of the mesh, but not under reflection.
/// Together with three fixed vertices that are not collinear it determines the shape.
///
/// h is the number of half-edges. Rings are stored one after another (compressed rows).
struct Encoding {
    std::vector<Index> ring_offsets;  ///< n + 1
    std::vector<Index> ring;          ///< h: the ring of each vertex, counter-clockwise
    std::vector<double> weights;      ///< h: w_ij, summing to 1 over a ring (equation 7)
    std::vector<double> cotangents;   ///< h: b_ij, of the angle between edge and normal (equation 9); or empty
    /// h: the factor of |v'_i - v'_j| in the normal offset: w_ij b_ij by equation 13, or u_ij b_ij for a steep ring,
    /// where b_ij is unbounded and its product with u_ij = |v'_i - v'_j| / sum_k |v'_i - v'_k| is not. Larger than
    /// these by what the soft normal is short of unit length at rest.
    std::vector<double> heights;

    std::vector<double> softening;  ///< n: of the predictor's normals, see SoftNormal

    std::vector<Index> guarded;               ///< vertices encoded by a fallback rule, ascending
    std::vector<std::uint8_t> guard_reasons;  ///< GuardReason flags, one entry for each in `guarded`

    std::vector<Index> steep_offset;    ///< n: where a steep ring's u_ij begin in steep_weights, else -1
    std::vector<double> steep_weights;  ///< u_ij of all steep rings

    Index vertex_count() const { return static_cast<Index>(steep_offset.size()); }
    bool predictable(Index vertex) const { return ring_offsets[vertex + 1] > ring_offsets[vertex]; }
    EncodedRing ring_of(Index vertex) const {
        const Index begin = ring_offsets[vertex];
        const Index steep = steep_offset[vertex];
        return {ring.data() + begin,    weights.data() + begin,
                heights.data() + begin, steep < 0 ? nullptr : steep_weights.data() + steep,
                softening[vertex],      ring_offsets[vertex + 1] - begin};
    }
    Index longest_ring() const;

    /// The vertices that each reason applies to, by the reason's name.
    std::map<std::string, std::vector<Index>> guarded_by_reason() const;
};

}  // namespace meanvalue
