// Takes jumps out of the paths of vertices that the targets do not ask for.
#pragma once

#include <cstddef>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"
#include "meanvalue/sequence/sequence.h"

namespace meanvalue {

/// The frames of one run, one after another, from the first that could be solved.
///
/// The *roughness* of a path x at frame t is its second difference less the mean of those around it, weighted by the
/// triangle of half-width w, which is the second difference over w frames:
/// (x(t+1) - 2 x(t) + x(t-1)) - (x(t+w) - 2 x(t) + x(t-w)) / w^2. Beyond its ends a path goes on rotated by 180
/// degrees about its last point. Where a minimum ceases to be, or where a loose solve catches up, roughness is about
/// as long as the jump; of steady motion it is the fourth difference. A quick swing has much of it, too: so
/// jumps are found by the roughness over w = 2, against the next frames alone.
class PathSmoother {
  public:
    /// @param is_solved flag of each frame; at most w from one that is not, nothing is known of roughness.
    /// @param half_width w, frames; below 2 nothing is smoothed. Not longer than the run less a frame.
    PathSmoother(std::vector<char> is_solved, Index half_width);

    /// Limits of the roughness of each frame, measured over w and over 2 frames.
    struct Limits {
        std::vector<double> wide, near;
    };

    /// The largest roughness that anchors ask for at each frame: that of their targets, rounded as shapes are, so
    /// that hard ones are within it; of those whose weights change, that of their vertices; of free ones none.
    /// @param first the clip's frame that the run's first is. @param vertices of the anchors. @param points of each
    /// frame of the run.
    Limits roughness_of(const Trajectories& trajectories, Index first, const std::vector<Index>& vertices,
                        const std::vector<float*>& points) const;

    /// What roughness exceeds the limit of its frame, as far as the one over 2 frames does, is taken out and spread
    /// as second difference over the triangle around it, which keeps where a path comes from and goes to. Paths that
    /// keep to either limit keep their bits.
    /// @param points of each frame, count x 3. @throws Cancelled.
    void smooth(const std::vector<float*>& points, std::size_t count, const Limits& limits,
                const Execution& execution) const;

  private:
    struct Term {
        Index frame;
        double factor;
    };
    using Terms = std::vector<Term>;

    /// @param result receives the roughness of `numbers` coordinates from `begin` on. @return that of the roughest
    /// point.
    static double sum(const Terms& terms, const std::vector<float*>& points, std::size_t begin, std::size_t numbers,
                      std::vector<double>& result);
    std::vector<char> find_jumps(const std::vector<float*>& points, std::size_t begin, std::size_t numbers,
                                 const Limits& limits, std::vector<double>& jumps) const;
    Terms roughness_at(Index frame, Index half_width) const;
    void add(Index frame, double factor, Terms& terms) const;
    /// What an excess of 1 at frame `from` moves frame `to` by.
    double shift(Index from, Index to) const;

    Index frame_count_;
    Index half_width_;
    std::vector<Terms> wide_, near_;  // of each frame; none: it is not known
    std::vector<double> response_;    // by the distance in frames: its second difference is 1 less the triangle
};

}  // namespace meanvalue
