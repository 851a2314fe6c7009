// The method for artists: at the minimum, without the false ones near it, at screen rate.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/deformation_energy.h"
#include "meanvalue/decode/fast/handle_paths.h"
#include "meanvalue/decode/fast/soft_constraints.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/linalg/supernodal_factor.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/optimise/unknowns.h"

namespace meanvalue {

/// A rigidity, and the energy's constant matrix with it: its factor, and its block of the fixed vertices.
struct FastStage {
    double rigidity = 0.0;
    SupernodalFactor factor;
    FixedCoupling coupling;  // where FastSolve::respond() needs it
};

/// One mesh of the hierarchy, with the energy on it at one or more rigidities.
struct FastLevel {
    Unknowns unknowns;
    std::unique_ptr<const DeformationEnergy> energy;
    std::vector<FastStage> stages;  // stiffest first; the last has the rigidity asked for
};

/// Minimises DeformationEnergy: makes what FastSolve solves with. Small meshes have no coarse level: theirs is the
/// whole one. Deterministic for any number of threads.
class FastDecoder : public Decoder {
  public:
    /// @param shape encoded with the soft anchors as such. @param soft soft anchors, in the region's vertex numbers;
    /// none of them fixed. @param handles n of the region,
    /// the handle of each fixed vertex and soft anchor or -1; or empty. @param rigidity 0 or more.
    /// @throws Cancelled, SolverFailure.
    FastDecoder(EncodedRegion shape, std::vector<SoftAnchor> soft, const std::vector<Index>& handles, double rigidity,
                int threads, Execution& execution);

    std::unique_ptr<Workspace> make_workspace(const Execution& execution) const override;
    DecodeReport decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                        Execution& execution) const override;
    Index row_count() const override { return static_cast<Index>(fine_->unknowns.rows.size()); }
    std::size_t bytes() const override;
    std::vector<Index> level_sizes() const override;
    Index longest_ring() const override;

  private:
    friend class FastSolve;

    std::unique_ptr<FastLevel> make_level(const Encoding& encoding, const RestCells& cells, Unknowns unknowns,
                                          std::vector<SoftAnchor> soft, const std::vector<double>& rigidities,
                                          bool is_whole, Execution& execution) const;

    double rigidity_;
    double size_;
    std::vector<SoftAnchor> soft_;  // by ascending vertex
    std::vector<double> hold_;      // n: what each vertex counts in carrying parts; empty where all anchors are hard
    Hierarchy hierarchy_;           // empty where the mesh is small
    std::unique_ptr<const HandlePaths> pieces_;
    std::unique_ptr<const FastLevel> fine_;
    std::unique_ptr<const FastLevel> coarse_;
    std::unique_ptr<const FastLevel> middle_;  // between them where the mesh is large; for cold solves
};

}  // namespace meanvalue
