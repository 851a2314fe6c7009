#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "meanvalue/sequence/run_plan.h"

namespace meanvalue {
namespace {

// Points whose paths fit into the cache, and their numbers.
constexpr std::size_t kPointsOfBlock = 64;
constexpr std::size_t kBlock = 3 * kPointsOfBlock;
// A step is compared with the median of so many to either side, which a snap of up to three steps does not change;
// and so many to either side of a snap's middle may be part of it.
constexpr Index kAround = 3;
// What is seen of a snap at once: its step against those so many before and behind.
constexpr Index kBeside = 2;
// Where there is no snap any more: steps that are far from it, and how many times theirs it is if it is one.
constexpr std::array<Index, 4> kFar = {-5, -4, 4, 5};
constexpr double kBlunt = 1.5;
constexpr double kSharp = 2.5;
// A step that exceeds the two beside it by less than this share of itself is of a swing, however fast.
constexpr double kOfStep = 0.6;
// Points whose excess is below so many limits stay, those of twice that go with the snap.
constexpr double kOfLimit = 1.5;
constexpr double kFewestFrames = 3.0;
// A step by which the weight of an anchor changes by more is asked for, however far the shape goes.
constexpr double kLetGo = 0.5;
constexpr double kUnseen = 1e-4;  // of the diagonal: what a step exceeds others by can't be seen

/// How far each of `numbers` coordinates exceeds the median of the steps around it.
/// @param at (frame) -> the coordinates then. @param step from the frame before it to frame `step`.
template <typename At>
void excess_over_median(const At& at, Index step, Index radius, std::size_t numbers, double* excess) {
    std::array<double, 2 * kAround + 1> steps;
    const auto middle = steps.begin() + radius;
    for (std::size_t k = 0; k < numbers; ++k) {
        for (Index near = -radius; near <= radius; ++near)
            steps[near + radius] = double{at(step + near)[k]} - at(step + near - 1)[k];
        const double own = *middle;
        std::nth_element(steps.begin(), middle, middle + radius + 1);
        excess[k] = own - *middle;
    }
}

double length_of(const double* vector) {
    return std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

}  // namespace

double fade(Index frame, Index count) {
    const double t = (frame + 1.0) / (count + 1.0);
    return t < 0.5 ? 2.0 * t * t : 1.0 - 2.0 * (1.0 - t) * (1.0 - t);
}

RunPaths::RunPaths(std::vector<float*> points, std::vector<Index> vertices, std::vector<char> is_solved)
    : points_(std::move(points)),
      vertices_(std::move(vertices)),
      is_solved_(std::move(is_solved)),
      frame_count_(static_cast<Index>(points_.size())) {}

bool RunPaths::are_solved(Index begin, Index end) const {
    return begin >= 0 && end <= frame_count_ &&
           std::find(is_solved_.begin() + begin, is_solved_.begin() + end, char{0}) == is_solved_.begin() + end;
}

/// Of the steps around one that are known; 0: none.
Index RunPaths::radius_around(Index step) const {
    Index radius = kAround;
    while (radius > 0 && !are_solved(step - radius - 1, step + radius + 1))
        --radius;
    return radius;
}

std::vector<double> RunPaths::limits(const Trajectories& trajectories, const std::vector<AnchorOfRegion>& anchors,
                                     Index first, double size) const {
    std::vector<double> asked(frame_count_, 0.0);
    for (Index step = 1; step < frame_count_; ++step) {
        const Index radius = radius_around(step);
        for (std::size_t k = 0; radius > 0 && k < anchors.size(); ++k) {
            const auto row_of = [&](Index frame) {
                return static_cast<std::size_t>(first + frame) * trajectories.anchor_count + anchors[k].number;
            };
            const auto weight = [&](Index frame) {
                return trajectories.weights.empty() ? 1.0 : trajectories.weights[row_of(frame)];
            };
            if (std::abs(weight(step) - weight(step - 1)) > kLetGo)
                asked[step] = std::numeric_limits<double>::infinity();
            bool counts = true;
            for (Index frame = step - radius - 1; frame <= step + radius; ++frame)
                counts = counts && weight(frame) > 0.0;
            if (!counts) continue;
            std::array<double, 3> excess;
            excess_over_median([&](Index frame) { return &trajectories.targets[3 * row_of(frame)]; }, step, radius, 3,
                               excess.data());
            asked[step] = std::max(asked[step], length_of(excess.data()));
        }
    }
    std::vector<double> result;
    for (Index step = 0; step < frame_count_; ++step) {
        const auto begin = asked.begin() + std::max<Index>(0, step - kAround);
        const auto end = asked.begin() + std::min(frame_count_, step + kAround + 1);
        result.push_back(*std::max_element(begin, end) + kUnseen * size);
    }
    return result;
}

std::vector<Snap> RunPaths::find_snaps(const std::vector<double>& limits, const Execution& execution) const {
    std::vector<double> beside(frame_count_, 0.0);  // how far each step exceeds those beside it
    std::vector<char> is_swing(frame_count_, 0);
    for (Index step = kBeside + 1; step + kBeside < frame_count_; ++step) {
        execution.check();
        if (!are_solved(step - kBeside - 1, step + kBeside + 1)) continue;
        const auto change = [&](Index at, std::size_t k) { return points_[at][k] - points_[at - 1][k]; };
        float most = 0.0F;
        std::size_t farthest = 0;
        for (const Index vertex : vertices_) {
            float square = 0.0F;
            for (std::size_t axis = std::size_t{3} * vertex; axis < std::size_t{3} * vertex + 3; ++axis) {
                const float excess =
                    change(step, axis) - 0.5F * (change(step - kBeside, axis) + change(step + kBeside, axis));
                square += excess * excess;
            }
            if (square <= most) continue;
            most = square;
            farthest = std::size_t{3} * vertex;
        }
        beside[step] = std::sqrt(double{most});
        const std::array<double, 3> own = {change(step, farthest), change(step, farthest + 1),
                                           change(step, farthest + 2)};
        is_swing[step] = beside[step] < kOfStep * length_of(own.data());
    }
    std::vector<Snap> snaps;
    for (Index step = kBeside + 1; step + kBeside < frame_count_; ++step) {
        if (beside[step] < *std::max_element(&beside[step - kBeside], &beside[step + kBeside] + 1)) continue;
        std::vector<double> far;
        for (const Index away : kFar) {
            if (step + away > kBeside && step + away + kBeside < frame_count_) far.push_back(beside[step + away]);
        }
        std::sort(far.begin(), far.end());
        const double around = std::max(limits[step], far.empty() ? 0.0 : far[far.size() / 2]);
        const double share = std::clamp((beside[step] / around - kBlunt) / (kSharp - kBlunt), 0.0, 1.0);
        if (share > 0.0 && !is_swing[step]) snaps.push_back({step, beside[step], share});
    }
    return snaps;
}

std::vector<char> RunPaths::spread(const std::vector<Snap>& snaps, const std::vector<double>& limits,
                                   const std::vector<char>& stays, Index most_frames, const Execution& execution) {
    struct Part {  // of a snap, which may take some steps
        double share = 0.0;
        Index begin = 0, end = 0;  // of the frames that it is spread over
    };
    std::vector<Part> parts(frame_count_);
    std::vector<char> is_moved(frame_count_, 0);
    for (const Snap& snap : snaps) {
        const double frames = std::ceil(std::sqrt(snap.length / limits[snap.frame]));
        const auto width = std::min(most_frames, static_cast<Index>(std::max(frames, kFewestFrames)));
        const Index last = std::min(frame_count_ - 1, snap.frame + kAround);
        for (Index step = std::max<Index>(1, snap.frame - kAround); step <= last; ++step) {
            Part& part = parts[step];
            if (radius_around(step) == 0 || snap.share <= part.share) continue;
            part = {snap.share, step, step};
            while (step - part.begin < width && part.begin > 0 && !stays[part.begin - 1])
                --part.begin;
            while (part.end - step < width && part.end < frame_count_ && !stays[part.end])
                ++part.end;
            std::fill(is_moved.begin() + part.begin, is_moved.begin() + part.end, char{1});
        }
    }
    if (snaps.empty()) return is_moved;
    std::vector<double> paths(frame_count_ * kBlock);
    std::vector<double> moves(frame_count_ * kBlock);
    std::array<double, kBlock> excess;
    for (std::size_t first = 0; first < vertices_.size(); first += kPointsOfBlock) {
        execution.check();
        const std::size_t numbers = 3 * std::min(kPointsOfBlock, vertices_.size() - first);
        const auto place_of = [&](std::size_t k) { return std::size_t{3} * vertices_[first + k / 3] + k % 3; };
        for (Index frame = 0; frame < frame_count_; ++frame) {
            for (std::size_t k = 0; k < numbers; ++k)
                paths[frame * kBlock + k] = points_[frame][place_of(k)];
        }
        std::fill(moves.begin(), moves.end(), 0.0);
        for (Index step = 1; step < frame_count_; ++step) {
            const Part& part = parts[step];
            if (part.begin == part.end) continue;
            excess_over_median([&](Index frame) { return &paths[frame * kBlock]; }, step, radius_around(step),
                               numbers, excess.data());
            for (std::size_t k = 0; k < numbers; k += 3) {
                const double share = std::clamp(length_of(&excess[k]) / (kOfLimit * limits[step]) - 1.0, 0.0, 1.0);
                for (std::size_t axis = k; axis < k + 3; ++axis)
                    excess[axis] *= part.share * share;
            }
            for (Index frame = part.begin; frame < part.end; ++frame) {
                const double there = fade(frame - part.begin, part.end - part.begin) - (frame < step ? 0.0 : 1.0);
                for (std::size_t k = 0; k < numbers; ++k)
                    moves[frame * kBlock + k] += there * excess[k];
            }
        }
        for (Index frame = 0; frame < frame_count_; ++frame) {
            if (!is_moved[frame]) continue;
            for (std::size_t k = 0; k < numbers; ++k)
                points_[frame][place_of(k)] =
                    static_cast<float>(paths[frame * kBlock + k] + moves[frame * kBlock + k]);
        }
    }
    return is_moved;
}

}  // namespace meanvalue
