// Method `fast`, bound: the levels of the mesh, each with its energy and its factored initial Hessians.
#pragma once

#include <memory>
#include <vector>

#include "meanvalue/decode/decoder.h"
#include "meanvalue/decode/fast/fast_problem.h"

namespace meanvalue {

/// Minimizes DeformationEnergy: makes what FastSolve solves with, coarse levels first. Small meshes have one level.
/// Deterministic for any number of threads.
class FastDecoder : public Decoder {
  public:
    /// @param shape a part that hangs together. @param soft soft anchors, in the region's vertex numbers;
    /// none of them fixed. @param handles n of the region,
    /// the handle of each fixed vertex and soft anchor or -1; or empty. @param rigidity 0 or more.
    /// @param stiffness n, Binding::stiffness of the region, or empty. @throws Cancelled, SolverFailure.
    FastDecoder(EncodedRegion shape, std::vector<SoftAnchor> soft, const std::vector<Index>& handles, double rigidity,
                std::vector<double> stiffness, int threads, Execution& execution);

    std::unique_ptr<const Decoder> early() const override;
    void finish(Execution& execution) override;
    std::unique_ptr<Workspace> make_workspace(const Execution& execution) const override;
    DecodeReport decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                        Execution& execution) const override;
    void remember(const Positions& answer, Workspace& workspace) const override;
    bool draft(const DecodeOptions& options, Workspace& workspace, Positions& positions,
               const Execution& execution) const override;
    Index row_count() const override { return static_cast<Index>(problem_.levels.front()->unknowns.rows.size()); }
    std::size_t bytes() const override;
    std::vector<Index> level_sizes() const override;
    Index longest_ring() const override;

  private:
    /// An early one: it has the coarsest level of `whole` alone.
    FastDecoder(EncodedRegion shape, FastProblem whole, int threads);

    /// Finds the hierarchy. @param handles, is_soft see CoarseningOptions.
    void coarsen(const std::vector<Index>& handles, std::vector<char> is_soft, double free_count,
                 Execution& execution);
    /// @pre coarsen().
    std::shared_ptr<const FastLevel> make_coarse_level(const Level& level, const std::vector<double>& rigidities,
                                                       Execution& execution) const;
    std::shared_ptr<const FastLevel> make_level(const Encoding& encoding, RestCells cells, Unknowns unknowns,
                                                std::vector<SoftAnchor> soft, const std::vector<double>& rigidities,
                                                int threads, Execution& execution) const;
    /// Of the level that cold solves begin on.
    std::vector<double> from_stiff() const;

    FastProblem problem_;
    // Of the whole mesh, until finish().
    Unknowns unknowns_;
    RestCells cells_;
    double unit_ = 0.0;  // energy_unit(), with soft anchors
};

}  // namespace meanvalue
