// Where one run of a clip fades into the next.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

/// The frames before frame `at`, of both runs: those of the earlier are where the result is, those of the later are
/// given here. Either run may come first.
class Seam {
  public:
    using Shape = std::unique_ptr<float[]>;  ///< n x 3

    explicit Seam(std::int64_t at) : at_(at) {}

    std::int64_t at() const { return at_; }
    /// The later run's shape of a frame, in order. @param shape nullptr where it could not be solved: the earlier
    /// run's stays.
    void add(Index frame, Shape shape);
    /// Called once by either run, when its frames are there; the second one does the work.
    /// @param overlap frames over which the earlier fades into the later. @param numbers of a shape.
    /// @param row the earlier run's shape of a frame, which is written to.
    void close(Index overlap, std::size_t numbers, const std::function<float*(Index frame)>& row);

  private:
    struct After {
        Index frame;
        Shape shape;
    };

    std::int64_t at_;
    std::vector<After> after_;
    std::atomic<int> sides_done_{0};
};

}  // namespace meanvalue
