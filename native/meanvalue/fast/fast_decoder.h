// The method for artists: at the minimum, without the false ones near it, at screen rate.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "meanvalue/fast/deformation_energy.h"
#include "meanvalue/fast/quasi_newton.h"
#include "meanvalue/fast/rigid_pieces.h"
#include "meanvalue/fast/secant_predictor.h"
#include "meanvalue/fast/springs.h"
#include "meanvalue/hierarchy/hierarchy.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/mesh/region.h"
#include "meanvalue/solver/decoder.h"
#include "meanvalue/solver/supernodal_factor.h"
#include "meanvalue/solver/unknowns.h"

namespace meanvalue {

/// Minimises DeformationEnergy. From rest: on a coarse level, stiff first and then less and less, and along the
/// handles' screws where they turn far, whichever ends lower; then splits; then the whole mesh, to the tolerance; in
/// between a level of a fifth, where the mesh is large. From a start, as while dragging: the constant matrix' answer
/// to what the fixed vertices have moved since, in several steps where that is far; then the whole mesh to the
/// tolerance, or where that takes many steps, from rest after all if that is lower. Small meshes have no coarse
/// level: theirs is the whole one. Deterministic for any number of threads.
class FastDecoder : public Decoder {
  public:
    /// @param soft soft anchors, in the region's vertex numbers; none of them fixed. @param handles n of the region,
    /// the handle of each fixed vertex and soft anchor or -1; or empty. @param rigidity 0 or more.
    /// @throws Cancelled, SolverFailure.
    FastDecoder(Region region, std::vector<SoftAnchor> soft, const std::vector<Index>& handles, double rigidity,
                int threads, Execution& execution);

    DecodeReport decode(const DecodeOptions& options, Positions& positions, Execution& execution) override;
    const Encoding& encoding() const override { return encoding_; }
    Index row_count() const override { return static_cast<Index>(fine_->unknowns.rows.size()); }
    Index detached_triangle_count() const override { return detached_triangle_count_; }
    std::size_t bytes() const override;
    std::vector<Index> level_sizes() const override;
    Index longest_ring() const override;
    const Timings& bind_timings() const override { return bind_timings_; }

  private:
    /// A rigidity, and the energy's constant matrix with it: its factor, and its block of the fixed vertices.
    struct Stage {
        double rigidity = 0.0;
        SupernodalFactor factor;
        FixedCoupling coupling;  // where respond() needs it
    };
    /// One mesh of the hierarchy, with what minimises the energy on it at one or more rigidities.
    struct SolverLevel {
        Unknowns unknowns;
        std::unique_ptr<DeformationEnergy> energy;
        QuasiNewton minimiser;
        std::vector<std::unique_ptr<Stage>> stages;  // stiffest first; the last has the rigidity asked for
    };

    std::unique_ptr<SolverLevel> make_level(const Encoding& encoding, Unknowns unknowns, std::vector<SoftAnchor> soft,
                                            const std::vector<double>& rigidities, Execution& execution) const;
    QuasiNewtonReport minimise(SolverLevel& level, std::size_t stage, double tolerance, int max_iterations,
                               Positions& positions, Execution& execution, bool keep_history = false);
    bool history_is_exact() const;
    double energy_tolerance_of(const DecodeOptions& options) const;
    void start_cold(const DecodeOptions& options, Positions& positions, Timings& timings, Execution& execution);
    void start_afresh_if_lower(const DecodeOptions& options, double energy, Positions& positions, Timings& timings,
                               Execution& execution);
    void start_from_rest(double tolerance, int max_iterations, Positions& positions, Execution& execution);
    void aim_springs(const DecodeOptions& options);
    void couple_fixed(SolverLevel& level, Stage& stage, const Execution& execution) const;
    void respond(SolverLevel& level, std::size_t stage, const Positions& previous, Positions& positions,
                 const Execution& execution) const;
    void put_balanced_targets(const Positions& previous, Positions& positions, Execution& execution);
    void follow_from(const Positions& previous, Positions& positions, Execution& execution);
    bool follow_drag(const Positions& previous, Positions& positions, Execution& execution);
    void follow_otherwise(const Positions& previous, double energy, Positions& positions, Execution& execution);
    Positions drivers_in(const Positions& positions) const;
    Positions drivers_of(const Positions& positions) const;
    double energy_of(SolverLevel& level, const Positions& positions, const Execution& execution) const;
    double relax_stage_by_stage(double tolerance, int max_iterations, Positions& positions, Execution& execution);
    double follow(const RigidPieces::Way& way, double tolerance, int max_iterations, Positions& positions,
                  Execution& execution);
    /// Where cold solves are made: the coarse level, or the only one.
    SolverLevel& starting_level() { return coarse_ ? *coarse_ : *fine_; }

    Region region_;
    int threads_;
    double rigidity_;
    double size_;
    std::vector<SoftAnchor> soft_;  // by ascending vertex
    std::vector<double> hold_;      // n: what each vertex counts in carrying parts; empty where all anchors are hard
    // Of the solve now running, see QuasiNewtonOptions.
    double energy_tolerance_ = 0.0;
    double highest_start_ = std::numeric_limits<double>::infinity();
    int patience_ = 0;
    int all_iterations_ = 0;  // of the solve now running
    Timings bind_timings_;
    Components components_;
    Index detached_triangle_count_ = 0;
    Encoding encoding_;
    Hierarchy hierarchy_;  // empty where the mesh is small
    std::unique_ptr<RigidPieces> pieces_;
    SecantPredictor predictor_;   // of the solves that each begin where the one before ended
    bool keeps_history_ = false;  // fine_'s minimiser: of the last of those, which came to its end
    std::unique_ptr<SolverLevel> fine_;
    std::unique_ptr<SolverLevel> coarse_;
    std::unique_ptr<SolverLevel> middle_;  // between them where the mesh is large; for cold solves
};

}  // namespace meanvalue
