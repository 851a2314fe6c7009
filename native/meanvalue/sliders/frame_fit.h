// Values of shape keys from one frame of targets, and from all frames of a motion.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// Anchors of a mesh with s shape keys, mixed linearly: row k is at `anchors + sum of value * offset`.
struct SliderModel {
    Positions anchors;      ///< k x 3, at rest
    Eigen::MatrixXd basis;  ///< 3k x s: offsets at value 1, the coordinates of an anchor below each other
    Eigen::VectorXd lower;  ///< s
    Eigen::VectorXd upper;  ///< s
    bool can_move = true;   ///< whether a rigid motion of the whole is found as well

    Eigen::Index anchor_count() const { return anchors.rows(); }
    Eigen::Index shape_count() const { return basis.cols(); }
    /// The values in the box nearest to zero: what the prior prefers.
    Eigen::VectorXd rest_values() const {
        return Eigen::VectorXd::Zero(shape_count()).cwiseMax(lower).cwiseMin(upper);
    }
    /// Where the anchors are, k x 3, before the whole is moved.
    Positions mix(const Eigen::VectorXd& values) const;
};

/// Anchors of one frame. Those without a target are left out.
struct FrameTargets {
    std::vector<Index> known;     ///< rows that have a target, in order
    Positions targets;            ///< one row for each of `known`
    std::vector<double> weights;  ///< of each of `known`, above 0
};

/// What is estimated of one frame.
struct FrameEstimate {
    Eigen::VectorXd values;                  ///< s
    Matrix3 rotation = Matrix3::Identity();  ///< of the whole
    Vector3 translation = Vector3::Zero();   ///< of the whole
    Eigen::VectorXd prior;                   ///< s: variance of each value before the targets are seen
    double noise = 0.0;                      ///< variance of a target's coordinate
    double scale = 0.0;                      ///< variance by which outliers are judged
    std::vector<double> trust;               ///< of each known anchor, from 1 to 0 for an outlier

    bool is_outlier(std::size_t row) const { return trust[row] < 0.05; }
    /// k x 3: targets minus the anchors that were found, NaN without a target.
    Positions residuals(const SliderModel& model, const FrameTargets& frame) const;
};

/// Values of frames before and after, to which those of this frame are drawn.
struct NeighbourPull {
    Eigen::VectorXd strength;  ///< s, one over a variance
    Eigen::VectorXd mean;      ///< s
};

/// How a small rigid motion about `centre` moves `points`, 3m x 6: three translations, three rotations.
Eigen::MatrixXd rigid_motions(const Positions& points, const Vector3& centre);

/// The motion of the whole by the best fit, everything else as before any target is seen. @pre three known anchors
/// where the whole can move, else one.
FrameEstimate begin_estimate(const SliderModel& model, const FrameTargets& frame, const Eigen::VectorXd& values);

/// Sparse Bayesian regression (Tipping 2001) within bounds: each value has a prior variance of its own, which is
/// estimated along with the noise, so that few values differ from rest. The rigid motion is eliminated from the
/// normal equations (variable projection); outliers lose their weight by Tukey's biweight.
/// @param pull may be null. @param rounds at most; it ends when values settle. @throws Cancelled.
void refine_estimate(const SliderModel& model, const FrameTargets& frame, const NeighbourPull* pull, int rounds,
                     const Execution& execution, FrameEstimate& estimate);

/// Ridge regression within bounds: every target is followed, all values have one weak prior. So values change no
/// faster than targets do, where refine_estimate() may change from one shape to another. @throws Cancelled.
void follow_targets(const SliderModel& model, const FrameTargets& frame, const Execution& execution,
                    FrameEstimate& estimate);

/// A quadratic function of s variables within a box.
struct BoxProblem {
    const Eigen::MatrixXd& hessian;   ///< s x s, positive definite
    const Eigen::VectorXd& gradient;  ///< s, the negative gradient at zero
    const Eigen::VectorXd& lower;     ///< s
    const Eigen::VectorXd& upper;     ///< s, not below `lower`
};

/// The minimum of 1/2 x^T H x - g^T x within the box, by projected Newton steps (Bertsekas 1982): variables at a
/// bound that the gradient presses against stay there, the others take a Newton step, clipped to the box.
/// @param start s, where it begins; it is clipped first.
Eigen::VectorXd minimise_in_box(const BoxProblem& problem, const Eigen::VectorXd& start);

/// Each frame by itself first; then values are drawn to those of the frames beside them, as strongly as they change
/// little from frame to frame beside their noise (a random walk whose variance is estimated from the differences over
/// one and over two frames).
/// @param least_known frames with fewer known targets take their values and motion from the frames beside them; one
/// frame at least has as many.
/// The same bits for any number of threads. @throws Cancelled.
std::vector<FrameEstimate> estimate_sequence(const SliderModel& model, const std::vector<FrameTargets>& frames,
                                             std::size_t least_known, int threads, const Execution& execution);

}  // namespace meanvalue
