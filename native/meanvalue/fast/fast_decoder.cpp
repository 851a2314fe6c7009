#include "meanvalue/fast/fast_decoder.h"

#include <algorithm>
#include <cmath>

#include "meanvalue/common/errors.h"
#include "meanvalue/encoding/encoder.h"
#include "meanvalue/mesh/one_ring.h"
#include "meanvalue/mesh/triangle_mesh.h"
#include "meanvalue/solver/carry_parts.h"

namespace meanvalue {
namespace {

// Free vertices of the coarse level: enough for the shape of limbs, few enough for hundreds of steps a second.
constexpr double kCoarseShare = 0.03;
constexpr double kFewestCoarse = 1500;
constexpr double kMostCoarse = 4000;
constexpr Index kTooManyCoarse = 8000;
// Of a level in between, where it has at least so many times the vertices of the coarse one: wrinkles that the coarse
// level is too coarse for are found there at a fifth of the cost.
constexpr double kMiddleShare = 0.2;
constexpr double kMiddleOverCoarse = 3.0;
// Below this a coarse level is not worth its splits.
constexpr std::size_t kSmallMesh = 3000;
// Cold solves begin stiff: a stiff shape finds the right turn of every limb, and softer ones keep it.
constexpr double kStiffness[] = {1000.0, 300.0, 100.0};
// Stages on the way, as shares of the size and in steps.
constexpr double kStageTolerance = 2e-4;
constexpr double kStiffTolerance = 5e-4;
constexpr int kMostStageSteps = 40;
// Handles that turn farther than this (120 degrees) are also followed along their way, in steps of at most the second
// angle. Nearer ones are found as well from the stiff stages; docs/algorithm.md has the count.
constexpr double kFarTurn = 2.1;
constexpr double kTurnOfStep = 0.26;
constexpr int kMostFollowSteps = 15;
constexpr double kFollowTolerance = 1e-3;
// With a start, handles that turn or move farther than this, the move as a share of the size, are followed in steps.
constexpr double kTurnOfResponse = 0.3;
constexpr double kMoveOfResponse = 0.05;
constexpr int kMostResponses = 24;
constexpr int kStepsOfResponse = 5;
// The same from rest, and what share of the other start's energy it has to be below.
constexpr int kStepsOfWay = 3;
constexpr double kFarBelow = 0.4;
// A start that is near a minimum takes fewer steps of the whole mesh.
constexpr int kMostWarmSteps = 60;
constexpr int kLookBack = 10;
constexpr double kStillFalling = 0.95;
// On the diagonal of the constant matrices, as a share of itself: keeps them positive definite where anchors leave
// something open. Not of the mean, which a single small star of triangles may raise far above all others.
constexpr double kLeastDiagonal = 1e-9;

}  // namespace

FastDecoder::FastDecoder(Region region, std::vector<SoftAnchor> soft, const std::vector<Index>& handles,
                         double rigidity, int threads, Execution& execution)
    : region_(std::move(region)),
      threads_(threads),
      rigidity_(rigidity),
      size_(bounding_box_diagonal(region_.positions)),
      soft_(std::move(soft)) {
    std::sort(soft_.begin(), soft_.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
    std::vector<char> is_soft(soft_.empty() ? 0 : region_.is_fixed.size(), 0);
    std::vector<char> is_held = region_.is_fixed;
    if (!soft_.empty()) hold_.assign(region_.is_fixed.size(), 1.0);
    for (const SoftAnchor& anchor : soft_) {
        is_soft[anchor.vertex] = is_held[anchor.vertex] = 1;
        hold_[anchor.vertex] = hardness_of(anchor.strength);
    }
    components_ = find_components(region_.positions, region_.faces, region_.is_fixed, execution, is_soft);
    OneRings rings;
    {
        const StageTimer timer(bind_timings_, "encode");
        const TriangleMesh mesh(static_cast<Index>(region_.vertices.size()), region_.faces, execution);
        detached_triangle_count_ = mesh.detached_count();
        rings = collect_one_rings(mesh, execution);
        encoding_ = encode(rings, region_.positions, threads_, execution);
    }
    pieces_ = std::make_unique<RigidPieces>(encoding_, region_.positions, is_held, handles, size_, execution);
    std::vector<double> stages;
    for (const double stiffness : kStiffness) {
        if (stiffness > rigidity_) stages.push_back(stiffness);
    }
    stages.push_back(rigidity_);
    Unknowns unknowns = find_unknowns(encoding_, region_.is_fixed);
    if (unknowns.free.size() > kSmallMesh) {
        {
            const StageTimer timer(bind_timings_, "hierarchy");
            CoarseningOptions options;
            const auto count = static_cast<double>(unknowns.free.size());
            const double coarse = std::clamp(kCoarseShare * count, kFewestCoarse, kMostCoarse);
            if (kMiddleShare * count > kMiddleOverCoarse * coarse)
                options.level_sizes.push_back(static_cast<Index>(kMiddleShare * count));
            options.level_sizes.push_back(static_cast<Index>(coarse));
            options.down_to_base = false;
            options.exact_order = false;
            options.thin_out_fixed = true;
            options.handles = handles;
            options.is_soft = std::move(is_soft);
            hierarchy_ = build_hierarchy(rings, region_.positions, region_.is_fixed, options, threads_, execution);
        }
        const StageTimer timer(bind_timings_, "coarse level");
        const auto make = [&](const Level& level) {
            std::vector<char> is_fixed = region_.is_fixed;
            for (std::size_t k = 0; k < level.removed_count; ++k)
                is_fixed[hierarchy_.order[k]] = 1;
            Unknowns remaining = find_unknowns(level.encoding, is_fixed);
            std::vector<SoftAnchor> soft;
            if (!soft_.empty()) {
                const double scale = energy_unit(level.encoding, remaining, region_.positions, execution) /
                                     energy_unit(encoding_, unknowns, region_.positions, execution);
                soft = coarse_soft_anchors(soft_, hierarchy_, level, region_.is_fixed.size(), scale);
            }
            return make_level(level.encoding, std::move(remaining), std::move(soft), stages, execution);
        };
        // A level that could not be made coarse is factored twice and not four times.
        if (hierarchy_.base().free_count > kTooManyCoarse && stages.size() > 2)
            stages = {stages.front(), stages.back()};
        coarse_ = make(hierarchy_.base());
        stages = {rigidity_};
        if (hierarchy_.levels.size() > 1) middle_ = make(hierarchy_.levels.front());
    }
    const StageTimer timer(bind_timings_, "factor");
    execution.begin_stage("factor");
    fine_ = make_level(encoding_, std::move(unknowns), soft_, stages, execution);
    if (fine_->stages.empty()) return;
    couple_fixed(*fine_, *fine_->stages.back(), execution);
    SolverLevel& starting = starting_level();
    if (!starting.stages.empty()) couple_fixed(starting, *starting.stages.front(), execution);
}

void FastDecoder::couple_fixed(SolverLevel& level, Stage& stage, const Execution& execution) const {
    stage.coupling = level.energy->fixed_coupling(stage.rigidity, execution);
}

std::unique_ptr<FastDecoder::SolverLevel> FastDecoder::make_level(const Encoding& encoding, Unknowns unknowns,
                                                                  std::vector<SoftAnchor> soft,
                                                                  const std::vector<double>& rigidities,
                                                                  Execution& execution) const {
    auto level = std::make_unique<SolverLevel>();
    level->unknowns = std::move(unknowns);
    level->energy = std::make_unique<DeformationEnergy>(
        encoding, level->unknowns, region_.positions, size_, DeformationEnergy::weights_for(rigidity_), execution,
        DeformationEnergy::Kernel::kFastest, Springs(std::move(soft), level->unknowns));
    level->minimiser = QuasiNewton(level->unknowns);
    if (level->unknowns.free.empty()) return level;
    for (const double rigidity : rigidities) {
        SparseMatrix hessian = level->energy->constant_hessian(rigidity, threads_, execution);
        for (Eigen::Index k = 0; k < hessian.cols(); ++k) {
            execution.check_every(k);
            double& diagonal = hessian.valuePtr()[hessian.outerIndexPtr()[k]];
            diagonal = diagonal > 0.0 ? diagonal * (1.0 + kLeastDiagonal) : 1.0;  // no row reaches this vertex
        }
        auto stage = std::make_unique<Stage>();
        stage->rigidity = rigidity;
        stage->factor.analyse(hessian, execution, threads_);
        if (!stage->factor.factorise(hessian, execution, threads_)) {
            throw SolverFailure(message("the system of ", hessian.cols(), " free vertices is singular"));
        }
        level->stages.push_back(std::move(stage));
    }
    return level;
}

QuasiNewtonReport FastDecoder::minimise(SolverLevel& level, std::size_t stage, double tolerance, int max_iterations,
                                        Positions& positions, Execution& execution) {
    const double rigidity = level.stages[stage]->rigidity;
    const auto energy = [&](const Positions& at, Positions& gradient) {
        return level.energy->evaluate(at, rigidity, gradient, threads_, execution);
    };
    QuasiNewtonOptions options;
    options.step_tolerance = tolerance * size_;
    options.max_iterations = max_iterations;
    options.threads = threads_;
    QuasiNewtonReport report =
        level.minimiser.minimise(energy, level.stages[stage]->factor, options, positions, execution);
    all_iterations_ += report.iterations();
    return report;
}

DecodeReport FastDecoder::decode(const DecodeOptions& options, Positions& positions, Execution& execution) {
    DecodeReport report;
    report.stop_reason = "no free vertices";
    if (fine_->unknowns.free.empty()) return report;
    execution.begin_stage("solve");
    aim_springs(options);
    all_iterations_ = 0;
    const int warm_limit = std::min(options.max_iterations, kMostWarmSteps);
    if (options.previous == nullptr) {
        start_cold(options, positions, report.timings, execution);
    } else {
        const StageTimer timer(report.timings, "follow");
        follow_from(*options.previous, positions, kStepsOfResponse, execution);
    }
    const auto minimise_whole = [&](int limit) {
        const StageTimer timer(report.timings, "minimise");
        return minimise(*fine_, fine_->stages.size() - 1, options.tolerance, limit, positions, execution);
    };
    QuasiNewtonReport minimised = minimise_whole(options.previous == nullptr ? options.max_iterations : warm_limit);
    if (options.previous != nullptr && minimised.at_limit && warm_limit < options.max_iterations) {
        // Where the energy still falls, the start was not near a minimum, and one from rest costs less than what may
        // still be before this one. In a valley that was dragged into, it falls slowly: there the shape stays.
        const std::vector<double>& energies = minimised.energies;
        if (rigidity_ > 0.0 && energies.back() < kStillFalling * energies[energies.size() - 1 - kLookBack])
            start_afresh_if_lower(options, minimised.energies.back(), positions, report.timings, execution);
        const QuasiNewtonReport rest = minimise_whole(options.max_iterations - warm_limit);
        minimised.energies.insert(minimised.energies.end(), rest.energies.begin() + 1, rest.energies.end());
        minimised.gradient = rest.gradient;
        minimised.converged = rest.converged;
        minimised.at_limit = rest.at_limit;
    }
    report.iterations = minimised.iterations();
    report.all_iterations = all_iterations_;
    report.energies = std::move(minimised.energies);
    report.initial_gradient = minimised.initial_gradient;
    report.gradient = minimised.gradient;
    report.converged = minimised.converged;
    report.stop_reason = minimised.converged  ? "converged"
                         : minimised.at_limit ? "iteration limit"
                                              : "no step lowers the energy further";
    return report;
}

/// Places the free vertices from the rest shape, coarse to fine, so that the whole mesh remains to be minimised.
void FastDecoder::start_cold(const DecodeOptions& options, Positions& positions, Timings& timings,
                             Execution& execution) {
    {
        const StageTimer timer(timings, "start");
        start_from_rest(options.tolerance, options.max_iterations, positions, execution);
    }
    if (!coarse_) return;
    const StageTimer timer(timings, "split");
    int level = static_cast<int>(hierarchy_.levels.size()) - 1;
    if (middle_) {
        hierarchy_.split(level, 0, positions, threads_, execution);
        level = 0;
        minimise(*middle_, 0, std::max(options.tolerance, kStageTolerance), options.max_iterations, positions,
                 execution);
    }
    hierarchy_.split(level, -1, positions, threads_, execution);
    if (!middle_) start_along_way_if_lower(options, positions, execution);
}

/// On smaller meshes the coarse level may be too coarse for small parts, whose details the splits then fold. The
/// whole mesh along the handles' way has them as they were: that start is taken where it is far below `positions`.
void FastDecoder::start_along_way_if_lower(const DecodeOptions& options, Positions& positions, Execution& execution) {
    Positions along = positions;
    for (const Index v : fine_->unknowns.free)
        along.row(v) = region_.positions.row(v);
    aim_springs(options);
    follow_from(region_.positions, along, kStepsOfWay, execution);
    aim_springs(options);
    Positions gradient(static_cast<Eigen::Index>(fine_->unknowns.free.size()), 3);
    const double split = fine_->energy->evaluate(positions, rigidity_, gradient, threads_, execution);
    const double followed = fine_->energy->evaluate(along, rigidity_, gradient, threads_, execution);
    if (followed < kFarBelow * split) std::swap(along, positions);
}

/// Starts from rest, and keeps that where it is below `energy`, that of `positions`.
void FastDecoder::start_afresh_if_lower(const DecodeOptions& options, double energy, Positions& positions,
                                        Timings& timings, Execution& execution) {
    aim_springs(options);
    Positions fresh = positions;
    fine_->energy->springs().put_targets(fresh);
    try {
        start_cold(options, fresh, timings, execution);
    } catch (const SolverFailure&) {
        aim_springs(options);
        return;  // what was found stays
    }
    Positions gradient(static_cast<Eigen::Index>(fine_->unknowns.free.size()), 3);
    aim_springs(options);
    if (fine_->energy->evaluate(fresh, rigidity_, gradient, threads_, execution) < energy)
        std::swap(positions, fresh);
}

void FastDecoder::aim_springs(const DecodeOptions& options) {
    for (SolverLevel* level : {fine_.get(), middle_.get(), coarse_.get()}) {
        if (level != nullptr && !level->energy->springs().empty())
            level->energy->springs().aim_at_targets(*options.targets);
    }
}

/// Moves the free vertices by what the constant matrix answers to the moves of the fixed ones: the least energy of
/// all displacements, as far as it is the same in every pose. Where an anchor moves alone, its surroundings are torn
/// instead, and minimising has to begin from a spike. @param previous where the fixed vertices were; in `positions`
/// they are where they go, and free ones where they were.
void FastDecoder::respond(SolverLevel& level, std::size_t stage, const Positions& previous, Positions& positions,
                          const Execution& execution) const {
    const FixedCoupling& coupling = level.stages[stage]->coupling;
    Positions moves(static_cast<Eigen::Index>(coupling.vertices.size()), 3);
    for (std::size_t k = 0; k < coupling.vertices.size(); ++k)
        moves.row(k) = positions.row(coupling.vertices[k]) - previous.row(coupling.vertices[k]);
    if (moves.isZero(0.0)) return;
    Positions answer = -(coupling.matrix * moves);
    level.stages[stage]->factor.solve(answer, answer, threads_, execution);
    for (std::size_t k = 0; k < level.unknowns.free.size(); ++k)
        positions.row(level.unknowns.free[k]) += answer.row(k);
}

/// Puts soft anchors to where the targets were that they were in balance with at `previous`: behind them by as much
/// as the rest of the energy pulls there. Not farther off than the present targets are, if it was no balance at all.
void FastDecoder::put_balanced_targets(const Positions& previous, Positions& positions, Execution& execution) {
    if (soft_.empty()) return;
    Springs& springs = fine_->energy->springs();
    Positions targets = previous;
    springs.put_targets(targets);
    springs.aim_at_vertices(previous);
    Positions gradient(static_cast<Eigen::Index>(fine_->unknowns.free.size()), 3);
    fine_->energy->evaluate(previous, rigidity_, gradient, threads_, execution);
    springs.aim_at_vertices(targets);
    for (const SoftAnchor& anchor : soft_) {
        const Index v = anchor.vertex;
        const Eigen::RowVector3d lag = gradient.row(fine_->unknowns.slot[v]) / (2.0 * anchor.strength);
        const double most = (targets.row(v) - previous.row(v)).norm();
        const double length = lag.norm();
        positions.row(v) = previous.row(v) + (length > most ? most / length : 1.0) * lag;
    }
}

/// Carries a shape that was near a minimum along with fixed vertices, and with the targets of springs, that have
/// moved since: along their ways, in steps that are short enough for the answer to each to be nearly straight.
/// @param steps_between iterations of the whole mesh after each but the last.
void FastDecoder::follow_from(const Positions& previous, Positions& positions, int steps_between,
                              Execution& execution) {
    SolverLevel& level = *fine_;
    const std::size_t stage = level.stages.size() - 1;
    Springs& springs = level.energy->springs();
    Positions begins = previous;
    put_balanced_targets(previous, begins, execution);
    Positions ends = positions;
    springs.put_targets(ends);
    const RigidPieces::Way way = pieces_->way_between(begins, ends);
    const double far =
        std::max(way.largest_angle_rad() / kTurnOfResponse, way.largest_move() / (kMoveOfResponse * size_));
    // Written so that what is not a number is one step.
    const int steps = far > 1.0 ? static_cast<int>(std::ceil(std::min<double>(far, kMostResponses))) : 1;
    Positions here = previous;
    for (int step = 1; step <= steps; ++step) {
        Positions next = here;
        springs.set_aside(here);
        way.place(static_cast<double>(step) / steps, next);
        springs.aim_at_vertices(next);
        springs.put_back(next);
        respond(level, stage, here, next, execution);
        here = std::move(next);
        if (step < steps) minimise(level, stage, kFollowTolerance, steps_between, here, execution);
    }
    for (const Index v : level.unknowns.free)
        positions.row(v) = here.row(v);
}

/// From rest, carried along with the fixed vertices.
void FastDecoder::start_from_rest(double tolerance, int max_iterations, Positions& positions, Execution& execution) {
    const RigidPieces::Way way = pieces_->way_to(positions);
    execution.check();
    const Positions carried = carry_parts(components_, region_.positions, positions, hold_);
    execution.check();
    for (std::size_t v = 0; v < region_.is_fixed.size(); ++v) {
        if (!region_.is_fixed[v]) positions.row(v) = carried.row(v);
    }
    SolverLevel& level = starting_level();
    const std::size_t last = level.stages.size() - 1;
    respond(level, 0, carried, positions, execution);
    const Positions start = positions;
    double energy = relax_stage_by_stage(tolerance, max_iterations, positions, execution);
    const auto keep_if_lower = [&](Positions& other, double other_energy) {
        if (!(other_energy < energy)) return;
        energy = other_energy;
        std::swap(positions, other);
    };
    // Stiff stages lead away from shapes that are perfect but larger or smaller.
    Positions gradient(static_cast<Eigen::Index>(level.unknowns.free.size()), 3);
    if (level.energy->evaluate(start, rigidity_, gradient, threads_, execution) < energy) {
        Positions carried_on = start;
        const QuasiNewtonReport report =
            minimise(level, last, std::max(tolerance, kStageTolerance), max_iterations, carried_on, execution);
        keep_if_lower(carried_on, report.energies.back());
    }
    if (way.largest_angle_rad() > kFarTurn) {
        Positions followed = region_.positions;
        const double followed_energy = follow(way, tolerance, max_iterations, followed, execution);
        keep_if_lower(followed, followed_energy);
    }
}

double FastDecoder::relax_stage_by_stage(double tolerance, int max_iterations, Positions& positions,
                                         Execution& execution) {
    SolverLevel& level = starting_level();
    for (std::size_t stage = 0; stage + 1 < level.stages.size(); ++stage)
        minimise(level, stage, kStiffTolerance, kMostStageSteps, positions, execution);
    return minimise(level, level.stages.size() - 1, std::max(tolerance, kStageTolerance), max_iterations, positions,
                    execution)
        .energies.back();
}

double FastDecoder::follow(const RigidPieces::Way& way, double tolerance, int max_iterations, Positions& positions,
                           Execution& execution) {
    SolverLevel& level = starting_level();
    const int steps = static_cast<int>(std::ceil(way.largest_angle_rad() / kTurnOfStep));
    // Springs are pulled along the way as the fixed vertices are.
    const auto place = [&](double fraction) {
        Springs& springs = level.energy->springs();
        springs.set_aside(positions);
        way.place(fraction, positions);
        springs.aim_at_vertices(positions);
        springs.put_back(positions);
    };
    for (int step = 1; step < steps; ++step) {
        place(static_cast<double>(step) / steps);
        minimise(level, level.stages.size() - 1, kFollowTolerance, kMostFollowSteps, positions, execution);
    }
    place(1.0);
    return minimise(level, level.stages.size() - 1, std::max(tolerance, kStageTolerance), max_iterations, positions,
                    execution)
        .energies.back();
}

std::vector<Index> FastDecoder::level_sizes() const {
    std::vector<Index> sizes = {static_cast<Index>(fine_->unknowns.free.size())};
    if (middle_) sizes.push_back(static_cast<Index>(middle_->unknowns.free.size()));
    if (coarse_) sizes.push_back(static_cast<Index>(coarse_->unknowns.free.size()));
    return sizes;
}

Index FastDecoder::longest_ring() const {
    return coarse_ ? std::max(encoding_.longest_ring(), hierarchy_.longest_ring()) : encoding_.longest_ring();
}

std::size_t FastDecoder::bytes() const {
    std::size_t sum = encoding_.bytes() + (coarse_ ? hierarchy_.bytes() : 0);
    for (const SolverLevel* level : {fine_.get(), middle_.get(), coarse_.get()}) {
        if (level == nullptr) continue;
        sum += level->energy->bytes() + level->minimiser.bytes();
        for (const auto& stage : level->stages)
            sum += stage->factor.bytes() + stage->coupling.bytes();
    }
    return sum;
}

}  // namespace meanvalue
