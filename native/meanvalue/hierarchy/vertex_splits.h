// How removed vertices are put back, in batches of vertices that do not need each other.
#pragma once

#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/encoding/encoding.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/ring_mesh.h"

namespace meanvalue {

/// Vertices with the rings that place them.
struct Splits {
    OneRings rings;               ///< n: of these vertices; kAbsent for all others
    std::vector<Index> vertices;  ///< s, in the order of use
    /// Bounds of batches: the rings of one batch have vertices of earlier batches, or such that are no splits at all.
    std::vector<Index> batches = {0};

    /// Places all vertices by equation 13. @param encoding of `rings`. @param positions n x 3, those of all others
    /// given. The same bits for any `threads`.
    void apply(const Encoding& encoding, Positions& positions, int threads, const Execution& execution) const;
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
    Splits take(const Execution& execution);

  private:
    OneRings rings_;               // in the order of removal, as the next
    std::vector<Index> vertices_;  // that were removed
    std::vector<Index> depth_;     // n: the batch that one of these is for, counted from 1; 0 for all others
};

}  // namespace meanvalue
