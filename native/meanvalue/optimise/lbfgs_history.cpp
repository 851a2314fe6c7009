#include "meanvalue/optimise/lbfgs_history.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "meanvalue/common/parallel.h"
#include "meanvalue/common/tolerances.h"

namespace meanvalue {
namespace {

/// sum_k a[k] b[k] in double precision, four sums side by side for the processor's vectors.
template <typename Number>
double dot(const float* a, const Number* b, std::int64_t count) {
    double sums[4] = {};
    for (std::int64_t k = 0; k + 4 <= count; k += 4) {
        for (std::int64_t lane = 0; lane < 4; ++lane)
            sums[lane] += static_cast<double>(a[k + lane]) * static_cast<double>(b[k + lane]);
    }
    for (std::int64_t k = count / 4 * 4; k < count; ++k)
        sums[0] += static_cast<double>(a[k]) * static_cast<double>(b[k]);
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// Adds factor * other to a vector, then multiplies it with `by`, where there are any: in one go through memory.
double add_and_multiply(Positions& vector, double factor, const std::vector<float>* other,
                        const std::vector<float>* by, int threads, const Execution& execution) {
    const auto rows = static_cast<Index>(vector.rows());
    const Index pieces = piece_count(rows);
    const int workers = std::clamp(pieces / 4, 1, threads);  // a thread is worth its waking for some pieces
    std::vector<double> sums(pieces, 0.0);
    parallel_pieces(rows, workers, execution, [&](Index piece, Index begin, Index end) {
        const std::int64_t first = std::int64_t{3} * begin;
        const std::int64_t count = std::int64_t{3} * (end - begin);
        double* const numbers = vector.data() + first;
        for (std::int64_t k = 0; other != nullptr && k < count; ++k)
            numbers[k] += factor * static_cast<double>((*other)[first + k]);
        if (by != nullptr) sums[piece] = dot(by->data() + first, numbers, count);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace

void LbfgsHistory::find_direction(const Positions& gradient, const Preconditioner& preconditioner, int threads,
                                  const Execution& execution, Positions& direction) const {
    direction = -gradient;
    double factor = 0.0;
    const std::vector<float>* other = nullptr;  // to be added before the next product
    const auto multiply = [&](const std::vector<float>* by) {
        return add_and_multiply(direction, factor, std::exchange(other, nullptr), by, threads, execution);
    };
    std::vector<double> shares(pairs_.size());
    for (std::size_t k = pairs_.size(); k-- > 0;) {
        shares[k] = multiply(&pairs_[k].step) / pairs_[k].curvature;
        factor = -shares[k];
        other = &pairs_[k].change;
    }
    multiply(nullptr);
    preconditioner.solve(direction, direction, threads, execution);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        factor = shares[k] - multiply(&pairs_[k].change) / pairs_[k].curvature;
        other = &pairs_[k].step;
    }
    multiply(nullptr);
}

void LbfgsHistory::remember(double length, const Positions& direction, const Positions& gradient,
                            const Positions& next, int threads, const Execution& execution) {
    const auto numbers = static_cast<std::size_t>(rows_) * 3;
    next_.step.resize(numbers);
    next_.change.resize(numbers);
    std::vector<Vector3> sums(piece_count(rows_));  // of squared steps, products of both, and squared changes
    parallel_pieces(rows_, threads, execution, [&](Index piece, Index begin, Index end) {
        const std::int64_t first = std::int64_t{3} * begin;
        const std::int64_t count = std::int64_t{3} * (end - begin);
        float* const step = next_.step.data() + first;
        float* const change = next_.change.data() + first;
        for (std::int64_t n = 0; n < count; ++n) {
            step[n] = static_cast<float>(length * direction.data()[first + n] / size_);
            change[n] = static_cast<float>((next.data()[first + n] - gradient.data()[first + n]) / size_);
        }
        sums[piece] = {dot(step, step, count), dot(step, change, count), dot(change, change, count)};
    });
    const Vector3 total = std::accumulate(sums.begin(), sums.end(), Vector3(Vector3::Zero()));
    next_.curvature = total[1];
    // Where the energy curves upwards by more than rounding; written so that what is not a number is not kept.
    if (!(next_.curvature > kSinglePrecision * std::sqrt(total[0] * total[2]))) return;
    if (pairs_.size() < kPairs) {
        pairs_.push_back(std::move(next_));
        next_ = Pair();
    } else {
        std::swap(pairs_.front(), next_);
        std::rotate(pairs_.begin(), pairs_.begin() + 1, pairs_.end());
    }
}

}  // namespace meanvalue
