// Solving on a bound mesh, from any number of threads.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/deform/binding.h"

namespace meanvalue {

class BoundMesh;
class Workspace;

struct SolveOptions {
    /// Share of a part's bounding-box diagonal at rest that a vertex may still move in a step; none: the method's
    /// default. With Method::kFast from rest a solve also ends when the energy falls by less than 50 times this share
    /// in four steps; kFull, and the coarse level of kPaper, when by less than 100 times in three steps in a row.
    std::optional<double> tolerance;
    int max_iterations = 1000;  ///< of each stage; stages before the last have limits of their own as well
    /// With a start, one for each of Solution::part_energies: that part also ends where it is not above this; or
    /// empty.
    std::vector<double> enough_energies = {};
    /// Leave nothing to a next solve: a tenth of the tolerance counts. With a start: the result is the one from rest
    /// unless a rough solve from there is lower, and goes on then. For the end of a drag.
    bool settle = false;
    /// In a drag: each frame is kept, and ends where a solve from rest settles. Large meshes go on from the frame
    /// before unless their coarsest level finds a lower energy from rest.
    bool is_kept = false;
    /// k numbers from 0 to 1, in the order of the anchors, or empty: what the strength of each soft anchor is
    /// multiplied with, 1 for hard ones. At 0 an anchor is free for this solve, and its target may be anything.
    std::vector<double> weights = {};
    int threads = 0;  ///< 0: as many as the mesh was bound with
};

struct Solution {
    /// n x 3; anchors exactly at their targets but for soft ones, fixed vertices exactly at rest.
    Positions vertices;
    /// What was minimized, in squared units of the input: G (equation 15), the cost of lengths where there is
    /// rigidity, and the springs of soft anchors.
    double energy = 0.0;
    double initial_energy = 0.0;
    double initial_gradient = 0.0;  ///< norm of the energy's derivative at the start, where computed
    double gradient = 0.0;          ///< and at the end, or where it was last linearized
    std::vector<double> energies;   ///< at the start and after each iteration
    /// Shares of the energy: parts of what may move that do not hang together are solved each by itself.
    std::vector<double> part_energies;
    /// n x (e + 1) for e examples: the weights of the rest shape and of each example at each vertex.
    std::vector<double> example_weights;
    int iterations = 0;      ///< of the whole mesh, in the last stage: those of `energies`
    int all_iterations = 0;  ///< with those of coarser levels and of the stages before the last
    bool converged = false;
    std::string stop_reason;
    Timings timings;  ///< seconds by stage
};

/// A mesh bound to its anchors. Expensive to make, cheap to solve again for other targets.
class Deformer {
  public:
    /// @param earlier a deformer to share parts with, or nullptr. Both stay usable; destroy them in any order.
    /// @pre `binding` is one of its binding_again() then.
    /// @param when_coarse where given, and where the method is kFast and the mesh large enough for coarse levels:
    /// receives an early deformer while the rest is being bound, on any thread. It solves by the coarsest level alone
    /// and carries the rest along: 5 to 35 % of the way off, anchors at their targets, no drafts. It keeps what it
    /// needs.
    /// @throws as BoundMesh.
    Deformer(const Binding& binding, Execution& execution, const Deformer* earlier = nullptr,
             const std::function<void(std::shared_ptr<Deformer>)>& when_coarse = {});
    explicit Deformer(const Binding& binding);
    Deformer(Deformer&&) noexcept;
    Deformer& operator=(Deformer&&) noexcept;
    ~Deformer();

    /// A Binding with the mesh, region of influence, method, threads, instructions and treatment of loose parts of
    /// this one. Its anchors, and what belongs to them, are yours to set.
    Binding binding_again() const;

    /// Places every free vertex so that the encoding is kept as well as the anchors at `targets` allow.
    ///
    /// Solves may run side by side on several threads: each has the bits that it has alone.
    /// @param targets k x 3, in the order of the anchors, hard and soft alike, none farther than kFarthestDiagonals.
    /// @param start n x 3, an earlier solution: free vertices start there, and the fast method follows what the
    ///        anchors have moved since. None: the rest shape.
    /// @throws InvalidInput, SolverFailure, Cancelled; the deformer stays usable.
    Solution solve(const PositionsView& targets, const std::optional<PositionsView>& start,
                   const SolveOptions& options, Execution& execution) const;
    /// Solves from rest, for targets in any matrix or map of Eigen's. @throws InvalidInput unless it has three
    /// columns.
    template <typename Derived>
    Solution solve(const Eigen::MatrixBase<Derived>& targets, const SolveOptions& options = {}) const {
        Execution execution;
        return solve(*share(targets, "targets"), {}, options, execution);
    }

    /// A series of solves, each from the last answer. The fast method predicts from these how the shape goes on
    /// (docs/decisions/0012-predicted-drags.md). Their bits depend on each other, and on no other solve.
    class Drag {
      public:
        /// @param start where the first solve begins, n x 3; none: at rest. What was bound is kept by both: destroy
        /// or move the deformer as you like. @throws InvalidInput.
        explicit Drag(const Deformer& deformer, const std::optional<PositionsView>& start = {});
        Drag(Drag&&) noexcept;
        Drag& operator=(Drag&&) noexcept;
        ~Drag();

        /// As Deformer::solve(). After an exception the next solve begins where this one did. One at a time: a second
        /// thread waits.
        Solution solve(const PositionsView& targets, const SolveOptions& options, Execution& execution);
        /// For targets in any matrix or map of Eigen's. @throws InvalidInput unless it has three columns.
        template <typename Derived>
        Solution solve(const Eigen::MatrixBase<Derived>& targets, const SolveOptions& options = {}) {
            Execution execution;
            return solve(*share(targets, "targets"), options, execution);
        }

        /// What solve() is going to give for targets near the last ones, in a few milliseconds and also while a solve
        /// goes on: what the answers so far predict, and what the initial Hessian answers to the handles besides
        /// (docs/decisions/0030-predicted-frames.md). n x 3; hard anchors at their targets. No solve depends on it.
        /// @param threads 0: as many as the mesh was bound with. @return none where too little is known of such a
        /// move, or by other methods than kFast. @throws InvalidInput, Cancelled.
        std::optional<Positions> draft(const PositionsView& targets, int threads, const Execution& execution) const;
        template <typename Derived>
        std::optional<Positions> draft(const Eigen::MatrixBase<Derived>& targets, int threads = 1) const {
            return draft(*share(targets, "targets"), threads, Execution());
        }

      private:
        struct State;
        std::unique_ptr<State> state_;
    };

    const BindReport& report() const;
    const BoundMesh& bound() const;

  private:
    struct State;

    explicit Deformer(std::unique_ptr<const BoundMesh> bound);

    std::unique_ptr<State> state_;
};

/// One pose of a mesh: binds and solves at once. For other targets of the same anchors, keep a Deformer.
/// @param vertices, faces, anchors as of Binding. @param targets k x 3, in the order of the anchors.
/// @throws as both.
template <typename Vertices, typename Faces, typename Anchors, typename Targets>
Solution deform(const Vertices& vertices, const Faces& faces, const Anchors& anchors, const Targets& targets,
                const SolveOptions& options = {}) {
    return Deformer(Binding(vertices, faces, anchors)).solve(targets, options);
}

}  // namespace meanvalue
