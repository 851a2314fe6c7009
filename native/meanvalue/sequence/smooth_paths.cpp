#include "meanvalue/sequence/smooth_paths.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace meanvalue {
namespace {

// Points whose paths fit into the cache, 56 frames of them.
constexpr std::size_t kBlock = 64;

// Roughness over so many frames, as a share of that over w, distinguishes a jump from a swing: one of 8 frames has
// 0.15.
constexpr Index kNear = 2;
constexpr double kOfSwing = 0.2;
constexpr double kOfJump = 0.5;

double length_of(const double* vector) {
    return std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

}  // namespace

PathSmoother::PathSmoother(std::vector<char> is_solved, Index half_width)
    : frame_count_(static_cast<Index>(is_solved.size())),
      half_width_(half_width),
      wide_(is_solved.size()),
      near_(is_solved.size()) {
    if (half_width_ < 2) return;
    const double width = half_width_;
    for (Index frame = 1; frame + 1 < frame_count_; ++frame) {
        const auto first = is_solved.begin() + std::max<Index>(0, frame - half_width_);
        const auto behind = is_solved.begin() + std::min(frame_count_, frame + half_width_ + 1);
        if (std::find(first, behind, char{0}) != behind) continue;
        wide_[frame] = roughness_at(frame, half_width_);
        near_[frame] = roughness_at(frame, std::min(kNear, half_width_));
    }
    // From beyond the triangle, where it is 0, to the middle.
    response_.assign(half_width_ + 1, 0.0);
    for (Index distance = half_width_ - 1; distance > 0; --distance) {
        const double triangle = (width - distance) / (width * width);
        response_[distance - 1] = 2.0 * response_[distance] - response_[distance + 1] - triangle;
    }
}

PathSmoother::Terms PathSmoother::roughness_at(Index frame, Index half_width) const {
    const double share = 1.0 / (static_cast<double>(half_width) * half_width);
    Terms terms;
    add(frame, -2.0 + 2.0 * share, terms);
    for (const Index side : {-1, 1}) {
        add(frame + side, 1.0, terms);
        add(frame + side * half_width, -share, terms);
    }
    return terms;
}

/// A frame beyond an end is that of the path rotated about it by 180 degrees: twice the end less the one as far
/// inside.
void PathSmoother::add(Index frame, double factor, Terms& terms) const {
    const Index last = frame_count_ - 1;
    if (frame < 0 || frame > last) {
        const Index end = frame < 0 ? 0 : last;
        add(end, 2.0 * factor, terms);
        add(2 * end - frame, -factor, terms);
        return;
    }
    const auto same = std::find_if(terms.begin(), terms.end(), [&](const Term& term) { return term.frame == frame; });
    if (same != terms.end()) {
        same->factor += factor;
    } else {
        terms.push_back({frame, factor});
    }
}

double PathSmoother::shift(Index from, Index to) const {
    const auto response = [&](Index distance) {
        distance = std::abs(distance);
        return distance < half_width_ ? response_[distance] : 0.0;
    };
    // And of what the rotated path has beyond either end.
    return response(to - from) - response(to + from) - response(to + from - 2 * (frame_count_ - 1));
}

PathSmoother::Limits PathSmoother::roughness_of(const Trajectories& trajectories, Index first,
                                                const std::vector<Index>& vertices,
                                                const std::vector<float*>& points) const {
    const auto row_of = [&](const Term& term, std::size_t anchor) {
        return static_cast<std::size_t>(first + term.frame) * vertices.size() + anchor;
    };
    const auto weight_of = [&](const Term& term, std::size_t anchor) {
        return trajectories.weights.empty() ? 1.0 : trajectories.weights[row_of(term, anchor)];
    };
    const auto largest = [&](const Terms& terms) {
        double most = 0.0;
        for (std::size_t anchor = 0; anchor < vertices.size() && !terms.empty(); ++anchor) {
            const double weight = weight_of(terms.front(), anchor);
            const bool is_steady = std::all_of(terms.begin(), terms.end(),
                                               [&](const Term& term) { return weight_of(term, anchor) == weight; });
            if (is_steady && weight == 0.0) continue;
            Vector3 sum = Vector3::Zero();
            for (const Term& term : terms) {
                const double* const target = &trajectories.targets[3 * row_of(term, anchor)];
                const float* const point = points[term.frame] + 3 * static_cast<std::size_t>(vertices[anchor]);
                for (int axis = 0; axis < 3; ++axis)
                    sum[axis] += term.factor * (is_steady ? static_cast<float>(target[axis]) : point[axis]);
            }
            most = std::max(most, length_of(sum.data()));
        }
        return most;
    };
    Limits limits;
    for (Index frame = 0; frame < frame_count_; ++frame) {
        limits.wide.push_back(largest(wide_[frame]));
        limits.near.push_back(largest(near_[frame]));
    }
    return limits;
}

double PathSmoother::sum(const Terms& terms, const std::vector<float*>& points, std::size_t begin,
                         std::size_t numbers, std::vector<double>& result) {
    std::fill(result.begin(), result.end(), 0.0);
    for (const Term& term : terms) {
        const float* const at = points[term.frame] + begin;
        for (std::size_t k = 0; k < numbers; ++k)
            result[k] += term.factor * at[k];
    }
    double longest = 0.0;
    for (std::size_t k = 0; k < numbers; k += 3)
        longest = std::max(longest, length_of(&result[k]));
    return longest;
}

/// @param jumps receives the share of the roughness of each frame and point that is a jump's, and not a swing's.
/// @return the frames that have any.
std::vector<char> PathSmoother::find_jumps(const std::vector<float*>& points, std::size_t begin, std::size_t numbers,
                                           const Limits& limits, std::vector<double>& jumps) const {
    std::vector<char> found(frame_count_, 0);
    std::vector<double> near(3 * kBlock);
    std::vector<double> wide(3 * kBlock);
    for (Index frame = 0; frame < frame_count_; ++frame) {
        double* const shares = &jumps[frame * kBlock];
        std::fill_n(shares, kBlock, 0.0);
        if (sum(near_[frame], points, begin, numbers, near) <= limits.near[frame]) continue;
        sum(wide_[frame], points, begin, numbers, wide);
        for (std::size_t k = 0; k < numbers; k += 3) {
            const double above = length_of(&near[k]) - limits.near[frame];
            const double length = length_of(&wide[k]);
            if (above <= kOfSwing * length) continue;
            shares[k / 3] = (above / length - kOfSwing) / (kOfJump - kOfSwing);
            found[frame] = 1;
        }
    }
    return found;
}

void PathSmoother::smooth(const std::vector<float*>& points, std::size_t count, const Limits& limits,
                          const Execution& execution) const {
    std::vector<double> excess(3 * kBlock);
    std::vector<double> jumps(frame_count_ * kBlock);
    std::vector<std::vector<double>> moves(frame_count_);  // empty: none
    for (std::size_t first = 0; first < count; first += kBlock) {
        execution.check();
        const std::size_t begin = 3 * first;
        const std::size_t numbers = 3 * std::min(kBlock, count - first);
        const std::vector<char> has_jumps = find_jumps(points, begin, numbers, limits, jumps);
        for (Index frame = 0; frame < frame_count_; ++frame) {
            // A jump may take some frames, and is spread as a whole: what is left of it would be a jump again.
            const Index from = std::max<Index>(0, frame - kNear);
            const Index behind = std::min(frame_count_, frame + kNear + 1);
            if (std::none_of(has_jumps.begin() + from, has_jumps.begin() + behind, [](char any) { return any; }))
                continue;
            if (sum(wide_[frame], points, begin, numbers, excess) <= limits.wide[frame]) continue;
            for (std::size_t k = 0; k < numbers; k += 3) {
                double share = 0.0;
                for (Index near = from; near < behind; ++near)
                    share = std::max(share, jumps[near * kBlock + k / 3]);
                const double length = length_of(&excess[k]);
                share = length > limits.wide[frame] ? std::min(share, 1.0 - limits.wide[frame] / length) : 0.0;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    excess[k + axis] *= share;
            }
            const Index end = std::min(frame_count_, frame + half_width_);
            for (Index to = std::max<Index>(0, frame - half_width_ + 1); to < end; ++to) {
                moves[to].resize(3 * kBlock, 0.0);
                const double factor = shift(frame, to);
                for (std::size_t k = 0; k < numbers; ++k)
                    moves[to][k] -= factor * excess[k];
            }
        }
        for (Index frame = 0; frame < frame_count_; ++frame) {
            float* const at = points[frame] + begin;
            for (std::size_t k = 0; k < moves[frame].size() && k < numbers; ++k)
                at[k] = static_cast<float>(at[k] + moves[frame][k]);
            moves[frame].clear();
        }
    }
}

}  // namespace meanvalue
