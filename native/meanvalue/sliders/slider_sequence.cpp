#include <algorithm>

#include "meanvalue/common/parallel.h"
#include "meanvalue/sliders/frame_fit.h"

namespace meanvalue {
namespace {

// Frames that one thread takes one after another, each begun from the last: fixed, so that results do not depend on
// threads.
constexpr Index kRun = 24;

// Rounds of the first frame of a run, of the others, and of a frame in each sweep.
constexpr int kFirstRounds = 40;
constexpr int kNextRounds = 15;
constexpr int kSweepRounds = 2;
constexpr int kSweeps = 6;

// Frames to each side whose values tell together which shapes are in use.
constexpr Index kWindow = 5;

// A value that never changes may still change by this share of its range from frame to frame.
constexpr double kLeastStep = 1e-3;

/// Variance of a value's step from frame to frame, by shape. White noise adds alike to differences over one and two
/// frames, a step adds twice to the latter.
Eigen::VectorXd step_variances(const SliderModel& model, const std::vector<FrameEstimate>& estimates,
                               const std::vector<Index>& seen) {
    const Eigen::VectorXd range = model.upper - model.lower;
    Eigen::VectorXd one = Eigen::VectorXd::Zero(range.size());
    Eigen::VectorXd two = one;
    double count = 0.0;
    for (std::size_t i = 2; i < seen.size(); ++i) {
        if (seen[i] != seen[i - 2] + 2) continue;
        one += (estimates[seen[i]].values - estimates[seen[i - 1]].values).array().square().matrix();
        two += (estimates[seen[i]].values - estimates[seen[i - 2]].values).array().square().matrix();
        count += 1.0;
    }
    const Eigen::VectorXd least = (kLeastStep * range).array().square().max(1e-12);
    if (count == 0.0) return range.array().square().max(1e-12);
    return ((two - one) / count).cwiseMax(least);
}

/// Which shapes are in use is alike in frames close in time: prior variances become their means over a window.
void share_priors(std::vector<FrameEstimate>& estimates) {
    const auto count = static_cast<Index>(estimates.size());
    std::vector<Eigen::VectorXd> priors(estimates.size());
    for (Index f = 0; f < count; ++f) {
        const Index begin = std::max<Index>(0, f - kWindow);
        const Index end = std::min<Index>(count, f + kWindow + 1);
        Eigen::VectorXd sum = Eigen::VectorXd::Zero(estimates[f].prior.size());
        for (Index g = begin; g < end; ++g)
            sum += estimates[g].prior;
        priors[f] = sum / static_cast<double>(end - begin);
    }
    for (Index f = 0; f < count; ++f)
        estimates[f].prior = priors[f];
}

NeighbourPull pull_of(const std::vector<FrameEstimate>& estimates, const Eigen::VectorXd& steps, Index f) {
    NeighbourPull pull{Eigen::VectorXd::Zero(steps.size()), Eigen::VectorXd::Zero(steps.size())};
    double count = 0.0;
    for (const Index g : {f - 1, f + 1}) {
        if (g < 0 || g >= static_cast<Index>(estimates.size())) continue;
        pull.mean += estimates[g].values;
        count += 1.0;
    }
    pull.mean /= std::max(count, 1.0);
    pull.strength = count * steps.cwiseInverse();
    return pull;
}

/// Frames without enough targets: values and motion between those of the frames beside them.
void fill_gaps(const std::vector<Index>& seen, std::vector<FrameEstimate>& estimates) {
    for (Index f = 0; f < static_cast<Index>(estimates.size()); ++f) {
        const auto next = std::lower_bound(seen.begin(), seen.end(), f);
        if (next != seen.end() && *next == f) continue;
        const FrameEstimate& after = estimates[next == seen.end() ? seen.back() : *next];
        const Index first = next == seen.begin() ? *next : *(next - 1);
        const FrameEstimate& before = estimates[first];
        const double share =
            next == seen.end() || next == seen.begin() ? 0.0 : static_cast<double>(f - first) / (*next - first);
        FrameEstimate between = before;
        between.values = (1.0 - share) * before.values + share * after.values;
        between.translation = (1.0 - share) * before.translation + share * after.translation;
        between.rotation =
            Eigen::Quaterniond(before.rotation).slerp(share, Eigen::Quaterniond(after.rotation)).toRotationMatrix();
        estimates[f] = between;
    }
}

}  // namespace

std::vector<FrameEstimate> estimate_sequence(const SliderModel& model, const std::vector<FrameTargets>& frames,
                                             std::size_t least_known, int threads, const Execution& execution) {
    std::vector<Index> seen;
    for (Index f = 0; f < static_cast<Index>(frames.size()); ++f) {
        if (frames[f].known.size() >= least_known) seen.push_back(f);
    }
    std::vector<FrameEstimate> estimates(frames.size());
    const std::size_t runs = (seen.size() + kRun - 1) / kRun;
    parallel_items(runs, threads, execution, [&](int /*worker*/, std::size_t run) {
        const std::size_t begin = run * kRun;
        const std::size_t end = std::min(seen.size(), begin + kRun);
        Eigen::VectorXd start = model.rest_values();
        for (std::size_t i = begin; i < end; ++i) {
            FrameEstimate& estimate = estimates[seen[i]];
            estimate = begin_estimate(model, frames[seen[i]], start);
            refine_estimate(model, frames[seen[i]], nullptr, i == begin ? kFirstRounds : kNextRounds, execution,
                            estimate);
            start = estimate.values;
        }
    });
    fill_gaps(seen, estimates);
    const Eigen::VectorXd steps = step_variances(model, estimates, seen);
    share_priors(estimates);
    // Every second frame, then the others: what is read is not written meanwhile.
    for (int sweep = 0; sweep < 2 * kSweeps; ++sweep) {
        std::vector<Index> turn;
        for (const Index f : seen) {
            if (f % 2 == sweep % 2) turn.push_back(f);
        }
        parallel_items((turn.size() + kRun - 1) / kRun, threads, execution, [&](int /*worker*/, std::size_t run) {
            const std::size_t end = std::min(turn.size(), (run + 1) * kRun);
            for (std::size_t i = run * kRun; i < end; ++i) {
                const NeighbourPull pull = pull_of(estimates, steps, turn[i]);
                refine_estimate(model, frames[turn[i]], &pull, kSweepRounds, execution, estimates[turn[i]]);
            }
        });
        fill_gaps(seen, estimates);
    }
    return estimates;
}

}  // namespace meanvalue
