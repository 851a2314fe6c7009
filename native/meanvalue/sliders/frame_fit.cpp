#include "meanvalue/sliders/frame_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "meanvalue/linalg/procrustes.h"

namespace meanvalue {
namespace {

// Values that change by less than this share of their range have settled.
constexpr double kSettled = 1e-4;

// A prior's standard deviation is at least this share of the range: smaller ones make the system ill-conditioned.
constexpr double kLeastDeviation = 1e-3;

// The prior of values that have to be steady, as a share of what the shape that the anchors see best weighs.
constexpr double kSteadyPrior = 0.01;
constexpr int kSteadyRounds = 20;

// Noise below this share of the shapes' size cannot be distinguished from rounding in single precision.
constexpr double kLeastNoise = 1e-5;

// Tukey's biweight: a residual of so many standard deviations of a coordinate counts nothing.
constexpr double kOutlier = 6.0;
// For its scale: the median of the squared length of a normal vector in three dimensions, and how fast it may fall.
constexpr double kMedianSquare = 2.366;
constexpr double kScaleFall = 0.25;
constexpr double kLeastTrust = 1e-6;

Eigen::VectorXd ranges(const SliderModel& model) {
    const Eigen::VectorXd range = model.upper - model.lower;
    return (range.array() > 0.0).select(range, 1.0);
}

double least_noise(const SliderModel& model) {
    const double square =
        model.basis.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, model.basis.size()));
    return std::max(kLeastNoise * kLeastNoise * square, std::numeric_limits<double>::min());
}

/// The system of the values after the rigid motion was eliminated: hessian * values = gradient.
struct NormalEquations {
    Eigen::MatrixXd hessian;
    Eigen::VectorXd gradient;
};

NormalEquations assemble(const SliderModel& model, const FrameTargets& frame, const FrameEstimate& estimate) {
    const auto count = static_cast<Eigen::Index>(frame.known.size());
    const Positions mixed = model.mix(estimate.values);
    Eigen::MatrixXd basis(3 * count, model.shape_count());
    Eigen::VectorXd wanted(3 * count);
    Eigen::VectorXd roots(3 * count);
    Positions points(count, 3);
    Vector3 centre = Vector3::Zero();
    double total = 0.0;
    for (Eigen::Index row = 0; row < count; ++row) {
        const Index k = frame.known[row];
        const double weight = frame.weights[row] * estimate.trust[row];
        basis.middleRows<3>(3 * row) = model.basis.middleRows<3>(3 * Eigen::Index{k});
        // In the space of the shapes, where the basis does not turn.
        const Vector3 back = estimate.rotation.transpose() * (Vector3(frame.targets.row(row)) - estimate.translation);
        wanted.segment<3>(3 * row) = back - Vector3(model.anchors.row(k));
        roots.segment<3>(3 * row).setConstant(std::sqrt(weight));
        points.row(row) = mixed.row(k);
        centre += weight * Vector3(mixed.row(k));
        total += weight;
    }
    basis.array().colwise() *= roots.array();
    wanted.array() *= roots.array();
    NormalEquations result;
    result.hessian = basis.transpose() * basis;
    result.gradient = basis.transpose() * wanted;
    if (!model.can_move) return result;
    Eigen::MatrixXd motions = rigid_motions(points, centre / total);
    motions.array().colwise() *= roots.array();
    Eigen::Matrix<double, 6, 6> inertia = motions.transpose() * motions;
    inertia.diagonal().array() += 1e-12 * inertia.trace();  // anchors on a line do not tell how they turn about it
    const Eigen::MatrixXd coupling = motions.transpose() * basis;
    const Eigen::MatrixXd solved = inertia.ldlt().solve(coupling);
    result.hessian -= coupling.transpose() * solved;
    result.gradient -= solved.transpose() * (motions.transpose() * wanted);
    return result;
}

/// The rigid motion that best carries the mixed anchors to their targets.
void fit_motion(const SliderModel& model, const FrameTargets& frame, FrameEstimate& estimate) {
    if (!model.can_move) return;
    const Positions mixed = model.mix(estimate.values);
    const auto count = static_cast<Eigen::Index>(frame.known.size());
    Positions from(count, 3);
    std::vector<Index> rows(count);
    std::vector<double> weights(count);
    for (Eigen::Index row = 0; row < count; ++row) {
        from.row(row) = mixed.row(frame.known[row]);
        rows[row] = static_cast<Index>(row);
        weights[row] = frame.weights[row] * estimate.trust[row];
    }
    const Correlation sums = correlate(from, frame.targets, rows.data(), rows.size(), weights);
    estimate.rotation = fit_rotation(sums.covariance);
    estimate.translation = sums.to_centre - estimate.rotation * sums.from_centre;
}

/// Squared distances of the known anchors from their targets.
std::vector<double> squared_distances(const SliderModel& model, const FrameTargets& frame,
                                      const FrameEstimate& estimate) {
    const Positions mixed = model.mix(estimate.values);
    std::vector<double> squares(frame.known.size());
    for (std::size_t row = 0; row < squares.size(); ++row) {
        const Vector3 place = estimate.rotation * Vector3(mixed.row(frame.known[row])) + estimate.translation;
        squares[row] = (Vector3(frame.targets.row(static_cast<Eigen::Index>(row))) - place).squaredNorm();
    }
    return squares;
}

void judge_outliers(const std::vector<double>& squares, double least, FrameEstimate& estimate) {
    std::vector<double> sorted = squares;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    // Falls slowly: at first all residuals are large, and none of them is an outlier yet.
    estimate.scale = std::max({*middle / kMedianSquare, kScaleFall * estimate.scale, least});
    for (std::size_t row = 0; row < squares.size(); ++row) {
        const double share = squares[row] / (kOutlier * kOutlier * estimate.scale);
        estimate.trust[row] = share < 1.0 ? std::max((1.0 - share) * (1.0 - share), kLeastTrust) : kLeastTrust;
    }
}

/// Noise and prior variances that explain the values best (an expectation-maximization step).
/// @param covariance the diagonal of the inverse of the system over the noise.
void estimate_variances(const SliderModel& model, const FrameTargets& frame, const std::vector<double>& squares,
                        const Eigen::VectorXd& covariance, FrameEstimate& estimate) {
    double freedom = model.can_move ? -6.0 : 0.0;
    double sum = 0.0;
    for (std::size_t row = 0; row < squares.size(); ++row) {
        freedom += 3.0 * frame.weights[row] * estimate.trust[row];
        sum += frame.weights[row] * estimate.trust[row] * squares[row];
    }
    const Eigen::VectorXd moved = estimate.values - model.rest_values();
    const Eigen::VectorXd range = ranges(model);
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
        const double variance = estimate.noise * covariance(i);
        if (moved(i) != 0.0) freedom -= std::max(0.0, 1.0 - variance / estimate.prior(i));
        // Half of it: a value at rest is at its bound and can differ to one side only.
        const double least = kLeastDeviation * range(i);
        estimate.prior(i) = std::max(moved(i) * moved(i) + 0.5 * variance, least * least);
    }
    estimate.noise = std::max(sum / std::max(freedom, 1.0), least_noise(model));
}

}  // namespace

Eigen::MatrixXd rigid_motions(const Positions& points, const Vector3& centre) {
    Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(3 * points.rows(), 6);
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
        const Vector3 arm = Vector3(points.row(k)) - centre;
        motions.block<3, 3>(3 * k, 0).setIdentity();
        motions.block<3, 3>(3 * k, 3) << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(), -arm.x(), 0.0;
    }
    return motions;
}

Positions SliderModel::mix(const Eigen::VectorXd& values) const {
    const Eigen::VectorXd offsets = basis * values;
    return anchors + Eigen::Map<const Positions>(offsets.data(), anchors.rows(), 3);
}

Positions FrameEstimate::residuals(const SliderModel& model, const FrameTargets& frame) const {
    const Positions mixed = model.mix(values);
    Positions result = Positions::Constant(mixed.rows(), 3, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t row = 0; row < frame.known.size(); ++row) {
        const Index k = frame.known[row];
        const Vector3 place = rotation * Vector3(mixed.row(k)) + translation;
        result.row(k) = frame.targets.row(static_cast<Eigen::Index>(row)) - place.transpose();
    }
    return result;
}

FrameEstimate begin_estimate(const SliderModel& model, const FrameTargets& frame, const Eigen::VectorXd& values) {
    FrameEstimate estimate;
    estimate.values = values;
    estimate.prior = (0.5 * ranges(model)).array().square();
    estimate.trust.assign(frame.known.size(), 1.0);
    fit_motion(model, frame, estimate);
    const std::vector<double> squares = squared_distances(model, frame, estimate);
    const auto mean = [&] {
        double sum = 0.0;
        for (const double square : squares)
            sum += square;
        return sum / static_cast<double>(3 * std::max<std::size_t>(1, squares.size()));
    }();
    estimate.noise = estimate.scale = std::max(mean, least_noise(model));
    return estimate;
}

void refine_estimate(const SliderModel& model, const FrameTargets& frame, const NeighbourPull* pull, int rounds,
                     const Execution& execution, FrameEstimate& estimate) {
    const Eigen::VectorXd rest = model.rest_values();
    const Eigen::VectorXd range = ranges(model);
    for (int round = 0; round < rounds; ++round) {
        execution.check();
        NormalEquations system = assemble(model, frame, estimate);
        const Eigen::VectorXd precision = estimate.noise * estimate.prior.cwiseInverse();
        system.hessian.diagonal() += precision;
        system.gradient += precision.cwiseProduct(rest);
        if (pull != nullptr) {
            system.hessian.diagonal() += estimate.noise * pull->strength;
            system.gradient += estimate.noise * pull->strength.cwiseProduct(pull->mean);
        }
        const Eigen::VectorXd before = estimate.values;
        estimate.values = minimise_in_box({system.hessian, system.gradient, model.lower, model.upper}, before);
        fit_motion(model, frame, estimate);
        const std::vector<double> squares = squared_distances(model, frame, estimate);
        judge_outliers(squares, least_noise(model), estimate);
        const Eigen::Index size = model.shape_count();
        const Eigen::MatrixXd inverse = system.hessian.llt().solve(Eigen::MatrixXd::Identity(size, size));
        estimate_variances(model, frame, squares, inverse.diagonal(), estimate);
        const double change = ((estimate.values - before).array() / range.array()).abs().maxCoeff();
        if (change < kSettled && estimate.scale <= estimate.noise * 4.0 && round > 2) break;
    }
}

void follow_targets(const SliderModel& model, const FrameTargets& frame, const Execution& execution,
                    FrameEstimate& estimate) {
    const Eigen::VectorXd squares = ranges(model).array().square();
    for (int round = 0; round < kSteadyRounds; ++round) {
        execution.check();
        NormalEquations system = assemble(model, frame, estimate);
        const double largest = system.hessian.diagonal().cwiseProduct(squares).maxCoeff();
        const Eigen::VectorXd precision =
            kSteadyPrior * std::max(largest, least_noise(model)) * squares.cwiseInverse();
        system.hessian.diagonal() += precision;
        system.gradient += precision.cwiseProduct(model.rest_values());
        const Eigen::VectorXd before = estimate.values;
        estimate.values = minimise_in_box({system.hessian, system.gradient, model.lower, model.upper}, before);
        fit_motion(model, frame, estimate);
        const double change = ((estimate.values - before).cwiseAbs2().cwiseQuotient(squares)).maxCoeff();
        if (!model.can_move || change < kSettled * kSettled) break;
    }
}

}  // namespace meanvalue
