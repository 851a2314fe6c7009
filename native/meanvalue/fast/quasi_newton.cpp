#include "meanvalue/fast/quasi_newton.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/common/parallel.h"

namespace meanvalue {
namespace {

// More pairs shorten the way less than they cost: docs/benchmarks.md.
constexpr int kPairs = 6;
// A step must lower the energy by this share of what its slope promises (Armijo).
constexpr double kSufficientDecrease = 1e-4;
constexpr int kMostHalvings = 20;
// Steps this short on end tell the end of the way from a single bad step.
constexpr int kShortSteps = 2;
// A pair is remembered where the energy curves upwards along it by more than rounding.
constexpr double kLeastCurvature = 1e-10;
// Rows of a partial sum: fixed, so that sums do not depend on the number of threads.
constexpr Index kPiece = 2048;

double dot(const Positions& a, const Positions& b, Index begin, Index end) {
    return a.middleRows(begin, end - begin).cwiseProduct(b.middleRows(begin, end - begin)).sum();
}

/// sums[k] = sum over all rows of what `products` fills in for each piece: count numbers.
template <typename Products>
std::vector<double> sum_of_pieces(Index rows, int count, int threads, std::vector<double>& scratch,
                                  const Execution& execution, const Products& products) {
    const Index pieces = (rows + kPiece - 1) / kPiece;
    scratch.assign(static_cast<std::size_t>(pieces) * count, 0.0);
    const auto in_piece = [&](Index piece) {
        products(piece * kPiece, std::min(rows, (piece + 1) * kPiece), scratch.data() + std::size_t(piece) * count);
    };
    parallel_for(rows, threads, execution, [&](Index begin, Index end) {
        // Every piece belongs to whoever is given its first row.
        for (Index piece = (begin + kPiece - 1) / kPiece; piece * kPiece < end; ++piece)
            in_piece(piece);
    });
    std::vector<double> sums(count, 0.0);
    for (Index piece = 0; piece < pieces; ++piece) {
        for (int k = 0; k < count; ++k)
            sums[k] += scratch[std::size_t(piece) * count + k];
    }
    return sums;
}

}  // namespace

QuasiNewton::QuasiNewton(const Unknowns& unknowns) : unknowns_(&unknowns) {
    const auto count = static_cast<Eigen::Index>(unknowns.free.size());
    // Without writing to them: filling hundreds of megabytes takes longer than a cancel may wait. All is written
    // before it is read.
    for (Positions* vectors : {&gradient_, &trial_gradient_, &direction_})
        vectors->resize(count, 3);
    pairs_.resize(kPairs);
    for (Pair& pair : pairs_) {
        pair.step.resize(count, 3);
        pair.change.resize(count, 3);
    }
    products_.setZero(kPairs, kPairs);
}

QuasiNewtonReport QuasiNewton::minimise(const Energy& energy, SupernodalFactor& factor,
                                        const QuasiNewtonOptions& options, Positions& positions,
                                        Execution& execution) {
    QuasiNewtonReport report;
    order_.clear();
    trial_ = positions;
    double value = energy(positions, gradient_);
    if (!std::isfinite(value)) throw SolverFailure("the energy of the start is not finite");
    report.energies.push_back(value);
    report.initial_gradient = gradient_.norm();
    int short_steps = 0;
    while (gradient_.squaredNorm() > 0.0) {
        if (report.iterations() == options.max_iterations) {
            report.at_limit = true;
            break;
        }
        execution.check();
        execution.set_progress(static_cast<double>(report.iterations()) / options.max_iterations);
        find_direction(factor, options.threads, execution);
        const double slope = (direction_.cwiseProduct(gradient_)).sum();
        const double longest = std::sqrt(direction_.rowwise().squaredNorm().maxCoeff());
        double length = slope < 0.0 ? 1.0 : 0.0;
        double trial_value = value;
        for (int halving = 0; length > 0.0; ++halving, length = halving > kMostHalvings ? 0.0 : 0.5 * length) {
            move_free(length, positions, trial_, options.threads, execution);
            trial_value = energy(trial_, trial_gradient_);
            // Written so that an energy that is not a number is refused.
            if (trial_value < value && trial_value <= value + kSufficientDecrease * length * slope) break;
        }
        if (length == 0.0) {
            if (order_.empty()) {
                // At the minimum but for rounding, or stuck.
                report.converged = longest < options.step_tolerance;
                break;
            }
            order_.clear();  // the history may be misleading: once more without it
            continue;
        }
        remember(length, options.threads, execution);
        std::swap(positions, trial_);
        std::swap(gradient_, trial_gradient_);
        value = trial_value;
        report.energies.push_back(value);
        short_steps = length * longest < options.step_tolerance ? short_steps + 1 : 0;
        if (short_steps == kShortSteps) break;
    }
    report.converged = report.converged || short_steps == kShortSteps || gradient_.squaredNorm() == 0.0;
    report.gradient = gradient_.norm();
    return report;
}

/// direction = -H g. With s_k, y_k the pairs, oldest first, and the products s_k . y_l known, the two loops of the
/// usual recursion need only s_k . g and y_k . (what comes out of the factor).
void QuasiNewton::find_direction(SupernodalFactor& factor, int threads, Execution& execution) {
    const auto count = static_cast<int>(order_.size());
    const auto rows = static_cast<Index>(gradient_.rows());
    const auto product = [&](int s, int y) { return products_(order_[s], order_[y]); };
    const std::vector<double> by_gradient =
        sum_of_pieces(rows, count, threads, sums_, execution, [&](Index begin, Index end, double* sums) {
            for (int k = 0; k < count; ++k)
                sums[k] = dot(pairs_[order_[k]].step, gradient_, begin, end);
        });
    std::vector<double> alpha(count);
    for (int k = count; k-- > 0;) {
        double along = -by_gradient[k];
        for (int later = k + 1; later < count; ++later)
            along -= alpha[later] * product(k, later);
        alpha[k] = along / product(k, k);
    }
    parallel_for(rows, threads, execution, [&](Index begin, Index end) {
        auto piece = direction_.middleRows(begin, end - begin);
        piece = -gradient_.middleRows(begin, end - begin);
        for (int k = 0; k < count; ++k)
            piece -= alpha[k] * pairs_[order_[k]].change.middleRows(begin, end - begin);
    });
    factor.solve(direction_, direction_, threads, execution);
    const std::vector<double> by_direction =
        sum_of_pieces(rows, count, threads, sums_, execution, [&](Index begin, Index end, double* sums) {
            for (int k = 0; k < count; ++k)
                sums[k] = dot(pairs_[order_[k]].change, direction_, begin, end);
        });
    std::vector<double> add(count);
    for (int k = 0; k < count; ++k) {
        double along = by_direction[k];
        for (int earlier = 0; earlier < k; ++earlier)
            along += add[earlier] * product(earlier, k);
        add[k] = alpha[k] - along / product(k, k);
    }
    parallel_for(rows, threads, execution, [&](Index begin, Index end) {
        for (int k = 0; k < count; ++k) {
            direction_.middleRows(begin, end - begin) +=
                add[k] * pairs_[order_[k]].step.middleRows(begin, end - begin);
        }
    });
}

/// Keeps the step just taken, length * direction, in place of the oldest.
void QuasiNewton::remember(double length, int threads, const Execution& execution) {
    int place = static_cast<int>(order_.size());
    if (place == kPairs) {
        place = order_.front();
        order_.erase(order_.begin());
    } else {
        std::vector<char> taken(kPairs, 0);
        for (const int used : order_)
            taken[used] = 1;
        place = static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    }
    Pair& pair = pairs_[place];
    const auto rows = static_cast<Index>(gradient_.rows());
    const auto count = static_cast<int>(order_.size());
    // With every pair kept: its step times the new change, and the new step times its change; then the new ones'.
    const std::vector<double> sums =
        sum_of_pieces(rows, 2 * count + 3, threads, sums_, execution, [&](Index begin, Index end, double* out) {
            pair.step.middleRows(begin, end - begin) = length * direction_.middleRows(begin, end - begin);
            pair.change.middleRows(begin, end - begin) =
                trial_gradient_.middleRows(begin, end - begin) - gradient_.middleRows(begin, end - begin);
            for (int k = 0; k < count; ++k) {
                out[2 * k] = dot(pairs_[order_[k]].step, pair.change, begin, end);
                out[2 * k + 1] = dot(pair.step, pairs_[order_[k]].change, begin, end);
            }
            out[2 * count] = dot(pair.step, pair.change, begin, end);
            out[2 * count + 1] = dot(pair.step, pair.step, begin, end);
            out[2 * count + 2] = dot(pair.change, pair.change, begin, end);
        });
    if (!(sums[2 * count] > kLeastCurvature * std::sqrt(sums[2 * count + 1] * sums[2 * count + 2]))) return;
    for (int k = 0; k < count; ++k) {
        products_(order_[k], place) = sums[2 * k];
        products_(place, order_[k]) = sums[2 * k + 1];
    }
    products_(place, place) = sums[2 * count];
    order_.push_back(place);
}

void QuasiNewton::move_free(double length, const Positions& from, Positions& to, int threads,
                            const Execution& execution) const {
    parallel_for(static_cast<Index>(unknowns_->free.size()), threads, execution, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index v = unknowns_->free[k];
            to.row(v) = from.row(v) + length * direction_.row(k);
        }
    });
}

std::size_t QuasiNewton::bytes() const {
    std::size_t numbers = gradient_.size() + trial_gradient_.size() + direction_.size() + trial_.size();
    for (const Pair& pair : pairs_)
        numbers += pair.step.size() + pair.change.size();
    return numbers * sizeof(double);
}

}  // namespace meanvalue
