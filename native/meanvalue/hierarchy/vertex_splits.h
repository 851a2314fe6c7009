// How removed vertices are put back, in batches of vertices that do not need each other.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {

/// Vertices with the rings that place them, one after another in the order of use; and once they are encoded, the
/// coefficients of equation 13.
struct Splits {
    std::vector<Index> vertices;             ///< s
    std::vector<std::size_t> offsets = {0};  ///< s + 1, of the rings
    std::vector<Index> ring;
    std::vector<char> closed;       ///< s: of the ring, RingKind::kClosed or else kOpen
    std::vector<double> weights;    ///< w_ij
    std::vector<double> heights;    ///< see Encoding::heights; no ring is steep
    std::vector<double> softening;  ///< s
    /// Bounds of batches: the rings of one batch have vertices of earlier batches, or such that are no splits at all.
    std::vector<Index> batches = {0};

    Index size() const { return static_cast<Index>(vertices.size()); }
    EncodedRing ring_of(Index split) const;  ///< @pre encoded
    /// Fills in the coefficients. @param positions n x 3. The same bits for any `threads`. @throws Cancelled.
    void encode(const PositionsView& positions, int threads, const Execution& execution);
    /// Places all vertices by equation 13. @pre encoded. @param positions n x 3, those of all others given. The same
    /// bits for any `threads`.
    void apply(Positions& positions, int threads, const Execution& execution) const;
    /// Places all vertices by the similarities that take their rings nearest to where these are (Procrustes; Horn
    /// 1987). Less exact than equation 13, but details seldom fold where a ring is a sliver. @param rest n x 3.
    void carry(const PositionsView& rest, Positions& positions, int threads, const Execution& execution) const;
    Index longest_ring() const;
};

/// Takes splits down in the order of removal, and gives them out in that of use.
class SplitRecorder {
  public:
    explicit SplitRecorder(Index vertex_count);

    void add(Index vertex, const RingView& ring);
    /// What was added since the last call, last removed first, sorted into batches.
    Splits take(int threads, const Execution& execution);

  private:
    Splits taken_;              // in the order of removal
    std::vector<Index> depth_;  // n: the batch that a vertex of `taken_` is for, counted from 1; 0 for all others
};

}  // namespace meanvalue
