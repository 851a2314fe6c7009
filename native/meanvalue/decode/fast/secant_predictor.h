// Predicts the next answer of a drag from the last ones: the predictor of a continuation method, by secants.
#pragma once

#include <deque>
#include <vector>

#include "meanvalue/common/execution.h"
#include "meanvalue/common/types.h"

namespace meanvalue {

/// How a shape answered to the last moves of its drivers (fixed vertices and the targets of soft anchors), solve
/// after solve of a chain in which each begins where the one before ended. A move of the drivers that is nearly a
/// combination of those is answered by the same combination of the changes of the shape: wrong by the square of the
/// move only, where the initial Hessian is wrong by a share of it. docs/decisions/0012-predicted-drags.md.
class SecantPredictor {
  public:
    SecantPredictor() = default;
    /// @param size of the shape: the unit of what is kept in single precision.
    explicit SecantPredictor(double size) : size_(size) {}

    bool has_answer() const { return is_answer_; }
    /// Whether the last answer was nearer to where it was expected than to the one before it.
    bool is_good() const { return is_good_; }
    const Positions& shape() const { return answer_; }     ///< the last answer, or where the drag began; n x 3
    const Positions& drivers() const { return drivers_; }  ///< then, d x 3
    /// Before a solve that begins at a shape that is no answer, n x 3, with the drivers at `drivers` (d x 3). Changes
    /// are kept if it is near the last answer, as that is which was settled since.
    void begin(const Positions& previous, const Positions& drivers);

    /// Moves `positions` (n x 3), which are where the solve begins, as the last changes predict for drivers that go
    /// to `goal` (d x 3); nothing moves where that is far from all of them. @return d x 3, where the drivers are
    /// then.
    Positions predict(const Positions& goal, Positions& positions, int threads, const Execution& execution) const;
    /// Where the soft drivers were for `shape` (n x 3), if that is near the last answer and so most likely of the
    /// same targets; else `otherwise` (s x 3).
    Positions soft_drivers(const Positions& shape, const Positions& otherwise) const;
    bool has_changes() const { return !changes_.empty(); }
    /// A change of shape (n x 3) by moves of the drivers (d x 3) that counts until the next answer.
    /// @param is_sound that little else is in it: see Change.
    void suppose(const Positions& shape, const Positions& moves, bool is_sound);
    /// Before the solve: where it begins, n x 3.
    void expect(const Positions& positions);

    /// What follows is no answer to this drag.
    void end() { is_answer_ = false; }
    void forget();

    /// After the solve. @param answer n x 3; @param drivers d x 3.
    void note(const Positions& answer, const Positions& drivers);

  private:
    struct Change {
        std::vector<float> shape;  // 3 n, in sizes
        Positions drivers;         // d x 3
        // It was foreseen well, so that it tells of the drivers, and not of a shape that came to rest meanwhile: it
        // may lead far.
        bool is_sound = false;
    };

    std::vector<double> shares_of(const Positions& move) const;
    bool is_near(const Positions& shape) const;
    bool is_foreseen(const Positions& answer, double share) const;
    void add(const Positions& shape, const Positions& moves, bool is_sound);

    double size_ = 1.0;
    bool is_answer_ = false;      // what answer_ is, and not only where a solve began that was cancelled
    std::deque<Change> changes_;  // the latest first
    Positions answer_;            // n x 3
    Positions drivers_;           // d x 3
    bool is_good_ = true;
    bool supposes_ = false;  // the latest change is no answer's
    Positions expected_;     // some rows of where the solve began
};

}  // namespace meanvalue
