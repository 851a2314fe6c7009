#include "meanvalue/optimise/lbfgs_history.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// A pair is remembered where the energy curves upwards along it by more than rounding.
constexpr double kLeastCurvature = 1e-6;
// Rows that stay in a core's cache.
constexpr Index kPart = 2048;

/// Numbers that are added up side by side, for the processor's vectors.
constexpr std::int64_t kLanes = 4;

/// sum_k a[k] b[k] in double precision.
template <typename Number>
double dot(const float* a, const Number* b, std::int64_t count) {
    double sums[kLanes] = {};
    std::int64_t k = 0;
    for (; k + kLanes <= count; k += kLanes) {
        for (std::int64_t lane = 0; lane < kLanes; ++lane)
            sums[lane] += static_cast<double>(a[k + lane]) * static_cast<double>(b[k + lane]);
    }
    for (std::int64_t lane = 0; k < count; ++k, ++lane)
        sums[lane] += static_cast<double>(a[k]) * static_cast<double>(b[k]);
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// to += factor * from
void add_scaled(double factor, const float* from, std::int64_t count, double* to) {
    for (std::int64_t k = 0; k < count; ++k)
        to[k] += factor * static_cast<double>(from[k]);
}

/// sums[k] = sum over all rows of what `products` fills in for each piece: count numbers.
template <typename Products>
std::vector<double> sum_of_pieces(Index rows, int count, int threads, std::vector<double>& scratch,
                                  const Execution& execution, const Products& products) {
    if (count == 0) return {};  // before the first step
    const Index pieces = piece_count(rows);
    scratch.assign(static_cast<std::size_t>(pieces) * count, 0.0);
    parallel_pieces(rows, threads, execution, [&](Index piece, Index begin, Index end) {
        products(begin, end, scratch.data() + std::size_t(piece) * count);
    });
    std::vector<double> sums(count, 0.0);
    for (Index piece = 0; piece < pieces; ++piece) {
        for (int k = 0; k < count; ++k)
            sums[k] += scratch[std::size_t(piece) * count + k];
    }
    return sums;
}

/// Calls body(first number, count of numbers) for rows [begin, end) in parts that stay in a core's cache.
template <typename Body>
void for_each_part(Index begin, Index end, const Body& body) {
    for (Index part = begin; part < end; part += kPart)
        body(std::int64_t{3} * part, std::int64_t{3} * (std::min(end, part + kPart) - part));
}

}  // namespace

LbfgsHistory::LbfgsHistory(Index rows, double size) : rows_(rows), size_(size), pairs_(kPairs + 1) {
    order_.reserve(pairs_.size());
    products_.setZero(kPairs + 1, kPairs + 1);
}

/// With s_k, y_k the pairs, oldest first, and the products s_k . y_l known, the two loops of the usual recursion need
/// only s_k . g and y_k . (what comes out of the factor).
void LbfgsHistory::find_direction(const Positions& gradient, const Preconditioner& preconditioner, double scaling,
                                  int threads, Execution& execution, Positions& direction) {
    const auto count = static_cast<int>(order_.size());
    const auto product = [&](int s, int y) { return products_(order_[s], order_[y]); };
    const auto products_with = [&](std::vector<float> Pair::*of_pair, const Positions& vector) {
        return sum_of_pieces(rows_, count, threads, sums_, execution, [&](Index begin, Index end, double* sums) {
            const std::int64_t first = std::int64_t{3} * begin;
            for (int k = 0; k < count; ++k) {
                sums[k] = dot((pairs_[order_[k]].*of_pair).data() + first, vector.data() + first,
                              std::int64_t{3} * (end - begin));
            }
        });
    };
    const std::vector<double> by_gradient = products_with(&Pair::step, gradient);
    std::vector<double> alpha(count);
    for (int k = count; k-- > 0;) {
        double along = -by_gradient[k];
        for (int later = k + 1; later < count; ++later)
            along -= alpha[later] * product(k, later);
        alpha[k] = along / product(k, k);
    }
    parallel_for(rows_, threads, execution, [&](Index begin, Index end) {
        for_each_part(begin, end, [&](std::int64_t first, std::int64_t numbers) {
            double* const to = direction.data() + first;
            const double* const from = gradient.data() + first;
            for (std::int64_t n = 0; n < numbers; ++n)
                to[n] = -scaling * from[n];
            for (int k = 0; k < count; ++k)
                add_scaled(-scaling * alpha[k], pairs_[order_[k]].change.data() + first, numbers, to);
        });
    });
    preconditioner.solve(direction, direction, threads, execution);
    if (count == 0) return;
    const std::vector<double> by_direction = products_with(&Pair::change, direction);
    std::vector<double> add(count);
    for (int k = 0; k < count; ++k) {
        double along = by_direction[k];
        for (int earlier = 0; earlier < k; ++earlier)
            along += add[earlier] * product(earlier, k);
        add[k] = alpha[k] - along / product(k, k);
    }
    parallel_for(rows_, threads, execution, [&](Index begin, Index end) {
        for_each_part(begin, end, [&](std::int64_t first, std::int64_t numbers) {
            for (int k = 0; k < count; ++k)
                add_scaled(add[k], pairs_[order_[k]].step.data() + first, numbers, direction.data() + first);
        });
    });
}

/// The place of a pair that is not in use.
int LbfgsHistory::free_place() const {
    std::vector<char> taken(pairs_.size(), 0);
    for (const int used : order_)
        taken[used] = 1;
    return static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
}

void LbfgsHistory::remember(double length, const Positions& direction, const Positions& gradient,
                            const Positions& next, int threads, const Execution& execution) {
    const int place = free_place();
    Pair& pair = pairs_[place];
    const auto numbers = static_cast<std::size_t>(rows_) * 3;
    pair.step.resize(numbers);
    pair.change.resize(numbers);
    const auto count = static_cast<int>(order_.size());
    // With every pair kept: its step times the new change, and the new step times its change; then the new ones'.
    const std::vector<double> sums =
        sum_of_pieces(rows_, 2 * count + 3, threads, sums_, execution, [&](Index begin, Index end, double* out) {
            const std::int64_t first = std::int64_t{3} * begin;
            const std::int64_t size = std::int64_t{3} * (end - begin);
            float* const step = pair.step.data() + first;
            float* const change = pair.change.data() + first;
            for (std::int64_t n = 0; n < size; ++n) {
                step[n] = static_cast<float>(length * direction.data()[first + n] / size_);
                change[n] = static_cast<float>((next.data()[first + n] - gradient.data()[first + n]) / size_);
            }
            for (int k = 0; k < count; ++k) {
                const Pair& known = pairs_[order_[k]];
                out[2 * k] = dot(known.step.data() + first, change, size);
                out[2 * k + 1] = dot(step, known.change.data() + first, size);
            }
            out[2 * count] = dot(step, step, size);
            out[2 * count + 1] = dot(step, change, size);
            out[2 * count + 2] = dot(change, change, size);
        });
    const double step_squared = sums[2 * count];
    const double step_by_change = sums[2 * count + 1];
    const double change_squared = sums[2 * count + 2];
    // Written so that what is not a number is not kept.
    if (!(step_by_change > kLeastCurvature * std::sqrt(step_squared * change_squared))) return;
    for (int k = 0; k < count; ++k) {
        products_(order_[k], place) = sums[2 * k];
        products_(place, order_[k]) = sums[2 * k + 1];
    }
    products_(place, place) = step_by_change;
    order_.push_back(place);
    if (order_.size() > kPairs) order_.erase(order_.begin());
}

}  // namespace meanvalue
