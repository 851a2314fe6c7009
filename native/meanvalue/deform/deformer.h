// One bound mesh: what depends on the rest shape, the anchor set and the region of influence is done once.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/stage_timer.h"
#include "meanvalue/common/types.h"
#include "meanvalue/mesh/components.h"
#include "meanvalue/solver/decoder.h"

namespace meanvalue {

/// How free vertices are found from the anchors.
enum class Method {
    kFast,   ///< converged, with rigidity, at screen rate
    kPaper,  ///< hierarchical decoding: section 3
    kFull,   ///< equation 15 to convergence from the rest pose: section 2.3
};

/// What None stands for.
constexpr double kDefaultRigidity = 15.0;

/// @throws InvalidInput for an unknown name, listing the known ones.
Method method_from_name(const std::string& name);

/// What a Deformer is bound to.
struct Binding {
    PositionsView vertices;  ///< n x 3 rest positions
    TrianglesView faces;     ///< m x 3
    std::vector<Index> anchors;
    std::optional<std::vector<char>> roi;  ///< n flags, true may move; none: every vertex may
    Method method = Method::kFast;
    int threads = 0;  ///< 0: every core
    /// k numbers, or empty: anchors of one handle move rigidly together, so that far turns can be followed along
    /// their way. Without, anchors joined by edges make a handle. Used by Method::kFast.
    std::vector<Index> handles = {};
    /// How much lengths count, 0 or more; see DeformationEnergy. None: the method's default. Only Method::kFast knows
    /// any but 0, which is the paper's energy.
    std::optional<double> rigidity = {};
    /// k strengths, or empty. Infinity: the anchor is met exactly, as all are where none are given. A number s above
    /// 0, at most 1e9: a soft anchor, a free vertex with the energy s |v - target|^2 besides that of the shape
    /// (DeformationEnergy), in squared units as that is, so that s has no unit. s / c for each of c vertices of a
    /// handle makes a spring of s for the handle; the energy of the shape falls as 1 / n in finer meshes of n
    /// vertices. Must be inside `roi`. Method::kFast only.
    std::vector<double> strengths = {};
};

/// What bind found, and what it cost.
struct BindReport {
    Index vertex_count = 0;
    Index free_count =
        0;  ///< vertices that are solved for: not those of parts without a single anchor or fixed vertex
    Index anchor_count = 0;
    Index row_count = 0;             ///< residuals that take part in a solve
    std::vector<Index> level_sizes;  ///< free vertices in each level, finest first
    Index longest_ring = 0;          ///< of any row in any level
    Index detached_triangle_count =
        0;  ///< triangles that fit no manifold; see TriangleMesh. Like `guarded`, of the part that takes part
    std::vector<Index> guarded;                    ///< vertices encoded by a fallback rule
    std::map<std::string, Index> guarded_reasons;  ///< how many vertices each reason applies to
    std::vector<Component> components;             ///< the parts of the mesh and what their fixed vertices leave open
    Timings timings;                               ///< seconds by stage
    std::size_t bytes = 0;                         ///< held by the encoding and the linear system, without the factor
};

struct SolveOptions {
    /// Share of the rest shape's bounding-box diagonal that a vertex may still move in a step; none: the method's
    /// default. With Method::kFast from rest a solve also ends when the energy falls by less than 50 times this share
    /// in four steps. With Method::kFull a solve also ends when the energy falls by less than 100 times this share in
    /// three steps on end.
    std::optional<double> tolerance;
    int max_iterations = 1000;  ///< of each stage; stages before the last have limits of their own as well
    /// With a start: solve from rest as well, and keep whichever ends at the lower energy. For the end of a drag, so
    /// that what stays is at least as good as what the targets alone give.
    bool settle = false;
};

struct Solution {
    Positions
        vertices;  ///< n x 3; anchors exactly at their targets but for soft ones, fixed vertices exactly at rest
    double energy = 0.0;  ///< what was minimised, squared units of the input: G, or with rigidity or soft
                          ///< anchors DeformationEnergy
    double initial_energy = 0.0;
    double initial_gradient = 0.0;  ///< norm of the energy's derivative at the start, where computed
    double gradient = 0.0;          ///< and at the end, or where it was last linearised
    std::vector<double> energies;   ///< at the start and after each iteration
    int iterations = 0;             ///< of the whole mesh, in the last stage: those of `energies`
    int all_iterations = 0;         ///< with those of coarser levels and of the stages before the last
    bool converged = false;
    std::string stop_reason;
    Timings timings;  ///< seconds by stage
};

/// A mesh bound to its anchors. Expensive to make, cheap to solve again for other targets.
class Deformer {
  public:
    /// @throws InvalidInput (numbers out of range, strengths that are not above 0, positions that are not finite, an
    /// anchor named twice, rings that are too long (RingRoom), ...),
    ///         SolverFailure, Cancelled.
    Deformer(const Binding& binding, Execution& execution);
    Deformer(const Deformer&) = delete;
    Deformer& operator=(const Deformer&) = delete;

    /// Places every free vertex so that the encoding is kept as well as the anchors at `targets` allow.
    /// @param targets k x 3, in the order of the anchors, hard and soft alike, none farther than kFarthestDiagonals.
    /// @param start n x 3, an earlier solution: free vertices start there, and the fast method follows what the
    ///        anchors have moved since. None: the rest shape.
    /// @throws InvalidInput, SolverFailure, Cancelled; the deformer stays usable. From any thread;
    ///         a second caller waits for the first, and may be cancelled meanwhile.
    Solution solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                   const SolveOptions& options, Execution& execution);

    const BindReport& report() const { return report_; }

  private:
    /// Rest shape with the anchors at their targets and everything else that may move at `start`, where given.
    Positions place_anchors(const PositionsView& targets, const std::optional<PositionsView>& start,
                            const Execution& execution) const;
    Positions rows_of_region(const PositionsView& positions, const Execution& execution) const;
    void fill_report(const std::vector<Index>& region_vertices);
    /// Waits for other threads' solves. @throws Cancelled; SolverFailure in a forked child, where one of the other
    /// process was in the middle of a solve.
    std::unique_lock<std::timed_mutex> take_turn(const Execution& execution);

    std::timed_mutex solving_;
    std::atomic<unsigned> solver_generation_;  // fork_generation() of the last that took its turn
    Method method_;
    double default_tolerance_ = 1e-6;
    Positions rest_;
    double diagonal_ = 0.0;  // of its bounding box
    std::vector<Index> anchors_;
    std::vector<char> is_fixed_;          // n: hard anchors, and what lies outside the region of influence
    std::vector<Index> region_vertices_;  // the decoder's vertex numbers in the mesh
    BindReport report_;
    std::unique_ptr<Decoder> decoder_;
};

/// Makes a Deformer on a thread of its own, so that a cancel waits neither for a look nor until all is freed that
/// bind has made so far: see run_abandonable(), which is why it copies the mesh and holds the execution.
/// @throws as the constructor of Deformer.
std::unique_ptr<Deformer> bind_abandonable(const Binding& binding, const std::shared_ptr<Execution>& execution);

}  // namespace meanvalue
