// Values of shape keys from the places of a few anchors: of handles, or of markers on a face.
#pragma once  // SPDX-License-Identifier: MPL-2.0

#include <memory>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/shared_arrays.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// A mesh with shape keys, of which a few vertices are seen.
struct SliderBinding {
    /// @param rest, shapes matrices or maps of Eigen's in any layout, which are copied; or what is shared already.
    /// @throws InvalidInput unless all have three columns.
    template <typename Rest, typename Shapes>
    SliderBinding(const Rest& rest, const Shapes& shapes, std::vector<Index> anchors)
        : rest(share(rest, "rest")), anchors(std::move(anchors)) {
        for (const auto& shape : shapes)
            this->shapes.push_back(share(shape, "a shape"));
    }

    SharedPositions rest;                 ///< n x 3
    std::vector<SharedPositions> shapes;  ///< one or more, n x 3 each: the mesh with this key alone at value 1
    std::vector<Index> anchors;           ///< k vertex numbers
    std::vector<double> lower = {};       ///< one for each shape; empty: 0
    std::vector<double> upper = {};       ///< one for each shape; empty: 1
    bool can_move = true;                 ///< whether the whole may turn and move, as a head does
    int threads = 0;                      ///< of solve_sequence(); 0: every core
};

struct SliderOptions {
    std::vector<double> weights = {};  ///< k, from 0 on: one over the variance of a target, up to a factor; empty: 1
    std::vector<double> start = {};    ///< one for each shape; empty: at rest
    bool steady = false;  ///< every target is followed, and values change as steadily as targets: to drag handles
};

struct SliderSolution {
    std::vector<double> values;  ///< one for each shape
    Matrix3 rotation;            ///< of the whole: targets are near rotation * mixed shape + translation
    Vector3 translation;
    Positions residuals;         ///< k x 3: targets minus what was found, NaN without a target
    std::vector<char> outliers;  ///< k: targets that were not followed
};

/// Finds the values within their bounds whose linear mix, `rest + sum of value * (shape - rest)`, has its anchors
/// at the targets, and the rigid motion of the whole. Few values differ from rest: each has a prior variance that is
/// estimated with the noise (sparse Bayesian learning, Tipping 2001). docs/algorithm.md, "Values of shape keys".
/// Its members may be called from several threads at once.
class SliderFit {
  public:
    /// @throws InvalidInput that names what is wrong with which shape or anchor.
    explicit SliderFit(const SliderBinding& binding);

    /// @param targets k x 3, NaN where a target is missing.
    /// @throws InvalidInput, among others where fewer than three targets are there (one, if the whole can't move);
    /// Cancelled.
    SliderSolution solve(const PositionsView& targets, const SliderOptions& options = {},
                         const Execution& execution = Execution()) const;

    /// Frames of one motion: values are smooth in time, as far as they change in it. Frames with fewer targets than
    /// solve() needs take theirs from the frames beside them.
    /// @param targets one k x 3 for each frame. @param weights k x frames, frame after frame, or empty.
    /// The same bits for any number of threads.
    /// @throws InvalidInput, Cancelled.
    std::vector<SliderSolution> solve_sequence(const std::vector<Positions>& targets,
                                               const std::vector<double>& weights = {},
                                               const Execution& execution = Execution()) const;

    /// Shapes that the anchors do not see: they move no anchor, or all as a rigid motion would. They stay at rest.
    const std::vector<Index>& unseen() const;
    /// Pairs of shapes that move the anchors alike, so that targets cannot tell which of the two it is.
    const std::vector<std::pair<Index, Index>>& alike() const;
    Index shape_count() const;
    Index anchor_count() const;

  private:
    struct Bound;

    std::shared_ptr<const Bound> bound_;
};

}  // namespace meanvalue
