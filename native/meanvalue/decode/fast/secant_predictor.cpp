#include "meanvalue/decode/fast/secant_predictor.h"

#include <cmath>
#include <utility>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// A handle that moves rigidly has six degrees of freedom.
constexpr std::size_t kMostChanges = 6;
// A change adds a direction if at least this share of it is not in later changes. Less is mostly rounding and what
// the end of a solve left, and would be blown up.
constexpr double kLeastNew = 0.3;
// A prediction goes at most so many times as far along a direction as the change went. Where no change leads so far,
// as when a hand has just begun to move, those go farther that are at least this share of the size and were foreseen
// within this share of the way: they hold little of what the ends of solves leave.
constexpr double kFarthest = 3.0;
constexpr double kLarge = 1e-3;
constexpr double kSound = 0.5;
constexpr double kFarthestOfSound = 100.0;
// The largest share of a move that the changes may leave unexplained: beyond it the initial Hessian predicts better.
constexpr double kMostLeft = 0.5;
// A shape is near another if no vertex is farther off than this share of the size.
constexpr double kNear = 0.01;
// Every so many vertices tell how good a prediction was, and whether a shape is near.
constexpr Index kSampled = 16;

double dot(const Positions& a, const Positions& b) {
    return a.cwiseProduct(b).sum();
}

}  // namespace

void SecantPredictor::forget() {
    is_answer_ = supposes_ = false;
    changes_.clear();
    answer_.resize(0, 3);
}

void SecantPredictor::begin(const Positions& previous, const Positions& drivers) {
    end();
    if (!changes_.empty() && (supposes_ || !is_near(previous))) changes_.clear();
    supposes_ = false;
    answer_ = previous;
    drivers_ = drivers;
    is_good_ = true;
}

/// The share of each change in the combination of them that is nearest to `move` (d x 3): by Gram and Schmidt, the
/// latest first. Empty where none is near.
std::vector<double> SecantPredictor::shares_of(const Positions& move) const {
    struct Direction {
        Positions drivers;           // what is new in a change
        std::vector<double> shares;  // of the changes in it
    };
    std::vector<Direction> directions;
    std::vector<double> shares(changes_.size(), 0.0);
    Positions left = move;
    const auto go_along = [&](std::size_t k, double farthest) {
        Direction next{changes_[k].drivers, std::vector<double>(changes_.size(), 0.0)};
        next.shares[k] = 1.0;
        for (const Direction& known : directions) {
            const double share = dot(known.drivers, next.drivers) / known.drivers.squaredNorm();
            next.drivers -= share * known.drivers;
            for (std::size_t j = 0; j < shares.size(); ++j)
                next.shares[j] -= share * known.shares[j];
        }
        if (!(next.drivers.norm() > kLeastNew * changes_[k].drivers.norm())) return;
        const double times = dot(next.drivers, left) / next.drivers.squaredNorm();
        if (!(std::abs(times) < farthest)) return;
        std::vector<double> then = shares;
        for (std::size_t j = 0; j < shares.size(); ++j) {
            then[j] += times * next.shares[j];
            // A sound one that is new beside an unsound one would lead that far as well.
            if (std::abs(times) > kFarthest && !changes_[j].is_sound && std::abs(then[j]) > kFarthest) return;
        }
        shares = std::move(then);
        left -= times * next.drivers;
        directions.push_back(std::move(next));
    };
    for (std::size_t k = 0; k < changes_.size(); ++k)
        go_along(k, kFarthest);
    for (std::size_t k = 0; k < changes_.size(); ++k)
        if (changes_[k].is_sound && changes_[k].drivers.cwiseAbs().maxCoeff() > kLarge * size_)
            go_along(k, kFarthestOfSound);
    // Written so that what is not a number is not near.
    if (!(left.norm() < kMostLeft * move.norm())) shares.clear();
    return shares;
}

Positions SecantPredictor::predict(const Positions& goal, Positions& positions, int threads,
                                   const Execution& execution) const {
    Positions drivers = drivers_;
    if (changes_.empty()) return drivers;
    const std::vector<double> shares = shares_of(goal - drivers_);
    for (std::size_t change = 0; change < shares.size(); ++change)
        drivers += shares[change] * changes_[change].drivers;
    parallel_for(static_cast<Index>(positions.rows()), threads, execution, [&](Index begin, Index end) {
        const std::size_t first = std::size_t{3} * begin;
        const std::size_t last = std::size_t{3} * end;
        double* const to = positions.data();
        for (std::size_t change = 0; change < shares.size(); ++change) {
            const double share = size_ * shares[change];
            if (share == 0.0) continue;
            const float* const from = changes_[change].shape.data();
            for (std::size_t n = first; n < last; ++n)
                to[n] += share * static_cast<double>(from[n]);
        }
    });
    return drivers;
}

Positions SecantPredictor::soft_drivers(const Positions& shape, const Positions& otherwise) const {
    const bool is_known = otherwise.rows() > 0 && answer_.rows() == shape.rows() && is_near(shape);
    return is_known ? Positions(drivers_.bottomRows(otherwise.rows())) : otherwise;
}

bool SecantPredictor::is_near(const Positions& shape) const {
    for (Index k = 0; k < shape.rows(); k += kSampled)
        if (!((shape.row(k) - answer_.row(k)).cwiseAbs().maxCoeff() <= kNear * size_)) return false;
    return true;
}

void SecantPredictor::expect(const Positions& positions) {
    expected_ = positions(Eigen::seqN(0, (positions.rows() + kSampled - 1) / kSampled, kSampled), Eigen::all);
}

/// Whether an answer is within a share of the way from the last one of where its solve began; root mean squares.
bool SecantPredictor::is_foreseen(const Positions& answer, double share) const {
    double missed = 0.0;
    double moved = 0.0;
    for (Index k = 0; k < expected_.rows(); ++k) {
        missed += (answer.row(kSampled * k) - expected_.row(k)).squaredNorm();
        moved += (answer.row(kSampled * k) - answer_.row(kSampled * k)).squaredNorm();
    }
    return missed <= share * share * moved;
}

void SecantPredictor::suppose(const Positions& shape, const Positions& moves, bool is_sound) {
    add(shape, moves, is_sound);
    supposes_ = true;
}

void SecantPredictor::note(const Positions& answer, const Positions& drivers) {
    is_answer_ = false;
    if (std::exchange(supposes_, false)) changes_.pop_front();
    if (drivers != drivers_) {
        is_good_ = is_foreseen(answer, 1.0);
        add(answer - answer_, drivers - drivers_, is_foreseen(answer, kSound));
    }
    answer_ = answer;
    drivers_ = drivers;
    is_answer_ = true;
}

/// The latest change.
void SecantPredictor::add(const Positions& shape, const Positions& moves, bool is_sound) {
    Change change;
    if (changes_.size() == kMostChanges) {
        change = std::move(changes_.back());
        changes_.pop_back();
    }
    const auto numbers = static_cast<std::size_t>(shape.size());
    change.shape.resize(numbers);
    for (std::size_t n = 0; n < numbers; ++n)
        change.shape[n] = static_cast<float>(shape.data()[n] / size_);
    change.drivers = moves;
    change.is_sound = is_sound;
    changes_.push_front(std::move(change));
}

}  // namespace meanvalue
