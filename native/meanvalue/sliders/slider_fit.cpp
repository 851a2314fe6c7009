#include "meanvalue/sliders/slider_fit.h"

#include <Eigen/QR>
#include <cmath>
#include <string>
#include <utility>

#include "meanvalue/common/checks.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/mean_row.h"
#include "meanvalue/common/parallel.h"
#include "meanvalue/sliders/frame_fit.h"

namespace meanvalue {
namespace {

// Below this share of its largest offset, what a shape does to the anchors is not seen.
constexpr double kUnseen = 1e-3;
// Cosine from which on two shapes move the anchors alike.
constexpr double kAlike = 0.995;

// Squares and their products stay in the range of double precision below it.
constexpr double kMostNumber = 1e60;

// Rounds of one frame; most settle in 10 to 25.
constexpr int kRounds = 40;

void require_moderate(const PositionsView& positions, const char* name) {
    require_finite(positions, name);
    const double most = positions.rows() > 0 ? positions.cwiseAbs().maxCoeff() : 0.0;
    if (most <= kMostNumber) return;
    throw InvalidInput(
        message(name, " has coordinates up to ", most, "; scale all so that they stay below ", kMostNumber));
}

void require_sizes(const SliderBinding& binding) {
    if (binding.shapes.empty()) throw InvalidInput("there are no shapes; give one or more");
    require_moderate(*binding.rest, "rest");
    for (std::size_t s = 0; s < binding.shapes.size(); ++s) {
        const std::string name = message("shapes[", s, "]");
        require_count(name.c_str(), binding.shapes[s]->rows(), "row", binding.rest->rows(), "vertices of rest");
        require_moderate(*binding.shapes[s], name.c_str());
    }
    if (binding.anchors.empty()) throw InvalidInput("there are no anchors; give three or more vertex numbers");
    for (std::size_t k = 0; k < binding.anchors.size(); ++k) {
        if (binding.anchors[k] >= 0 && binding.anchors[k] < binding.rest->rows()) continue;
        throw InvalidInput(message("anchors[", k, "] is ", binding.anchors[k], ", but the mesh has ",
                                   binding.rest->rows(), " vertices; give numbers from 0 to ",
                                   binding.rest->rows() - 1));
    }
}

/// @param fallback for all, where none are given.
Eigen::VectorXd bounds_of(const std::vector<double>& given, std::size_t count, double fallback, const char* name) {
    if (given.empty()) return Eigen::VectorXd::Constant(static_cast<Eigen::Index>(count), fallback);
    require_count(name, given.size(), "number", count, "shapes");
    for (std::size_t s = 0; s < count; ++s) {
        if (!(std::abs(given[s]) <= kMostNumber)) {
            throw InvalidInput(message(name, "[", s, "] is ", given[s], "; give a number of moderate size"));
        }
    }
    return Eigen::Map<const Eigen::VectorXd>(given.data(), static_cast<Eigen::Index>(count));
}

SliderModel model_of(const SliderBinding& binding) {
    SliderModel model;
    const auto anchors = static_cast<Eigen::Index>(binding.anchors.size());
    const std::size_t shapes = binding.shapes.size();
    model.anchors.resize(anchors, 3);
    model.basis.resize(3 * anchors, static_cast<Eigen::Index>(shapes));
    model.can_move = binding.can_move;
    for (Eigen::Index k = 0; k < anchors; ++k) {
        const Index vertex = binding.anchors[k];
        model.anchors.row(k) = binding.rest->row(vertex);
        for (std::size_t s = 0; s < shapes; ++s) {
            model.basis.block<3, 1>(3 * k, static_cast<Eigen::Index>(s)) =
                (binding.shapes[s]->row(vertex) - binding.rest->row(vertex)).transpose();
        }
    }
    model.lower = bounds_of(binding.lower, shapes, 0.0, "lower");
    model.upper = bounds_of(binding.upper, shapes, 1.0, "upper");
    for (Eigen::Index s = 0; s < model.lower.size(); ++s) {
        if (model.lower(s) <= model.upper(s)) continue;
        throw InvalidInput(message("lower[", s, "] is ", model.lower(s), ", above upper[", s, "], which is ",
                                   model.upper(s), "; give a lower bound that is not above the upper one"));
    }
    return model;
}

/// The basis without what a small rigid motion of the whole does as well.
Eigen::MatrixXd seen_basis(const SliderModel& model) {
    if (!model.can_move) return model.basis;
    const Vector3 centre = mean_row(model.anchors);
    const Eigen::MatrixXd motions = rigid_motions(model.anchors, centre);
    return model.basis - motions * motions.colPivHouseholderQr().solve(model.basis);
}

}  // namespace

struct SliderFit::Bound {
    SliderModel model;
    std::vector<Index> unseen;
    std::vector<std::pair<Index, Index>> alike;
    int threads = 0;

    void find_what_is_seen(const SliderBinding& binding);
    FrameTargets known_targets(const PositionsView& targets, const double* weights) const;
    std::size_t least_known() const { return model.can_move ? 3 : 1; }
    SliderSolution solution_of(const FrameTargets& frame, const FrameEstimate& estimate) const;
};

void SliderFit::Bound::find_what_is_seen(const SliderBinding& binding) {
    const Eigen::MatrixXd seen = seen_basis(model);
    std::vector<Index> visible;
    for (Index s = 0; s < static_cast<Index>(binding.shapes.size()); ++s) {
        const double largest = (*binding.shapes[s] - *binding.rest).rowwise().norm().maxCoeff();
        const Eigen::Map<const Positions> offsets(seen.col(s).data(), model.anchor_count(), 3);
        if (offsets.rowwise().norm().maxCoeff() <= kUnseen * largest) {
            unseen.push_back(s);
            model.basis.col(s).setZero();
        } else {
            visible.push_back(s);
        }
    }
    for (std::size_t i = 0; i < visible.size(); ++i) {
        for (std::size_t j = i + 1; j < visible.size(); ++j) {
            const Index a = visible[i];
            const Index b = visible[j];
            const double cosine = seen.col(a).dot(seen.col(b)) / (seen.col(a).norm() * seen.col(b).norm());
            const bool both_ways = model.lower(a) < 0.0 || model.lower(b) < 0.0;
            if (cosine > kAlike || (both_ways && cosine < -kAlike)) alike.emplace_back(a, b);
        }
    }
}

FrameTargets SliderFit::Bound::known_targets(const PositionsView& targets, const double* weights) const {
    if (targets.rows() != model.anchor_count()) {
        throw InvalidInput(message("targets has ", targets.rows(), " rows for ", model.anchor_count(),
                                   " anchors; give one for each, NaN where it is missing"));
    }
    FrameTargets frame;
    for (Index k = 0; k < static_cast<Index>(targets.rows()); ++k) {
        const double weight = weights == nullptr ? 1.0 : weights[k];
        if (!(weight >= 0.0 && weight <= kMostNumber)) {
            throw InvalidInput(message("weights[", k, "] is ", weight, "; give a number from 0 to ", kMostNumber));
        }
        if (weight > 0.0 && targets.row(k).allFinite()) frame.known.push_back(k);
    }
    frame.targets = targets(frame.known, Eigen::all);
    double sum = 0.0;
    for (const Index k : frame.known) {
        frame.weights.push_back(weights == nullptr ? 1.0 : weights[k]);
        sum += frame.weights.back();
    }
    for (double& weight : frame.weights)  // their mean is 1, so that the noise is that of a usual target
        weight *= static_cast<double>(frame.known.size()) / sum;
    require_moderate(frame.targets, "targets");
    return frame;
}

SliderSolution SliderFit::Bound::solution_of(const FrameTargets& frame, const FrameEstimate& estimate) const {
    SliderSolution solution;
    solution.values.assign(estimate.values.data(), estimate.values.data() + estimate.values.size());
    solution.rotation = estimate.rotation;
    solution.translation = estimate.translation;
    solution.residuals = estimate.residuals(model, frame);
    solution.outliers.assign(static_cast<std::size_t>(model.anchor_count()), 0);
    for (std::size_t row = 0; row < frame.known.size(); ++row)
        solution.outliers[frame.known[row]] = estimate.is_outlier(row) ? 1 : 0;
    return solution;
}

SliderFit::SliderFit(const SliderBinding& binding) {
    require_sizes(binding);
    auto bound = std::make_unique<Bound>();
    bound->model = model_of(binding);
    bound->threads = thread_count(binding.threads);
    bound->find_what_is_seen(binding);
    if (bound->unseen.size() == binding.shapes.size()) {
        throw InvalidInput("no shape moves any anchor beyond a rigid motion; give anchors where the shapes move");
    }
    bound_ = std::move(bound);
}

SliderSolution SliderFit::solve(const PositionsView& targets, const SliderOptions& options,
                                const Execution& execution) const {
    const auto anchors = static_cast<std::size_t>(anchor_count());
    if (!options.weights.empty()) require_count("weights", options.weights.size(), "number", anchors, "anchors");
    Eigen::VectorXd start = bound_->model.rest_values();
    if (!options.start.empty()) start = bounds_of(options.start, shape_count(), 0.0, "start");
    const double* weights = options.weights.empty() ? nullptr : options.weights.data();
    const FrameTargets frame = bound_->known_targets(targets, weights);
    if (frame.known.size() < bound_->least_known()) {
        throw InvalidInput(message("targets are there for ", frame.known.size(), " anchors; give ",
                                   bound_->least_known(), " or more"));
    }
    FrameEstimate estimate = begin_estimate(bound_->model, frame, start);
    if (options.steady) {
        follow_targets(bound_->model, frame, execution, estimate);
    } else {
        refine_estimate(bound_->model, frame, nullptr, kRounds, execution, estimate);
    }
    return bound_->solution_of(frame, estimate);
}

std::vector<SliderSolution> SliderFit::solve_sequence(const std::vector<Positions>& targets,
                                                      const std::vector<double>& weights,
                                                      const Execution& execution) const {
    const auto anchors = static_cast<std::size_t>(anchor_count());
    if (targets.empty()) throw InvalidInput("targets has no frames; give one or more");
    if (!weights.empty())
        require_count("weights", weights.size(), "number", targets.size() * anchors, "anchors of all frames");
    std::vector<FrameTargets> frames;
    frames.reserve(targets.size());
    std::size_t most = 0;
    for (std::size_t f = 0; f < targets.size(); ++f) {
        frames.push_back(bound_->known_targets(targets[f], weights.empty() ? nullptr : &weights[f * anchors]));
        most = std::max(most, frames.back().known.size());
    }
    if (most < bound_->least_known()) {
        throw InvalidInput(message("no frame has targets for more than ", most, " anchors; give ",
                                   bound_->least_known(), " or more in one frame at least"));
    }
    const std::vector<FrameEstimate> estimates =
        estimate_sequence(bound_->model, frames, bound_->least_known(), bound_->threads, execution);
    std::vector<SliderSolution> solutions;
    solutions.reserve(frames.size());
    for (std::size_t f = 0; f < frames.size(); ++f)
        solutions.push_back(bound_->solution_of(frames[f], estimates[f]));
    return solutions;
}

const std::vector<Index>& SliderFit::unseen() const {
    return bound_->unseen;
}

const std::vector<std::pair<Index, Index>>& SliderFit::alike() const {
    return bound_->alike;
}

Index SliderFit::shape_count() const {
    return static_cast<Index>(bound_->model.shape_count());
}

Index SliderFit::anchor_count() const {
    return static_cast<Index>(bound_->model.anchor_count());
}

}  // namespace meanvalue
