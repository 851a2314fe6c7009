// The multiresolution encoding (paper, section 3.1): vertices are removed, each encoded by its ring at that time,
// and some of the meshes on the way are kept as levels.
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

/// What to remove, and what to keep of the meshes on the way.
struct CoarseningOptions {
    /// Numbers of free vertices, descending: a level is kept when so many are left, or as few as can be.
    std::vector<Index> level_sizes;
    /// Go on until nothing can be removed, and keep that level too. Else the last of `level_sizes` is the end.
    bool down_to_base = true;
    /// Fixed vertices may be removed as well, where they are as dense as the free ones: merged into fixed neighbors
    /// of the same handle, of which each connected part keeps its extreme points.
    bool thin_out_fixed = false;
    /// n, or empty: which handle a fixed or soft vertex belongs to; ignored for others. Without it such neighbors
    /// are of one handle.
    std::vector<Index> handles;
    /// n flags, or empty: free vertices with springs. They are thinned out in the same way, apart from the fixed
    /// ones.
    std::vector<char> is_soft;
};

/// A soft vertex that was merged into one of its own kind.
struct SoftMerge {
    Index removed;
    Index into;
};

/// The mesh at one moment of the coarsening.
struct Level {
    std::size_t removed_count = 0;  ///< how many of Hierarchy::order were gone
    Index free_count = 0;           ///< free vertices that were left
    Encoding encoding;              ///< n rows: every vertex that was still there, by its ring then
    Splits splits;                  ///< from here to the next finer level, or from the finest to the whole mesh
};

/// An order of removal with all that is needed to undo it for other positions. Vertex numbers stay those of the mesh.
struct Hierarchy {
    std::vector<Index> order;            ///< removed vertices, first removed first
    std::vector<Level> levels;           ///< finest first; at least one
    std::vector<SoftMerge> soft_merges;  ///< in the order of removal

    /// The coarsest level.
    const Level& base() const { return levels.back(); }
    Index longest_ring() const;  ///< of all rings in `levels`
};

/// Removes vertices by half-edge collapses, cheapest first, and encodes the shape along that order. A collapse is
/// legal where it keeps topology and boundary, bounds the rings, and leaves the removed vertex with a stencil that
/// does not amplify.
/// @param rings of the whole mesh.
/// @param positions n x 3.
/// @param is_fixed n flags: their positions are always given.
/// @param threads the result is the same for any number.
/// @throws Cancelled. Cost: about linear.
Hierarchy build_hierarchy(const OneRings& rings, const PositionsView& positions, const std::vector<char>& is_fixed,
                          const CoarseningOptions& options, int threads, Execution& execution);

}  // namespace meanvalue
