#include "meanvalue/decode/fast/fast_decoder.h"

#include <algorithm>
#include <utility>

#include "meanvalue/common/elementary.h"
#include "meanvalue/common/errors.h"
#include "meanvalue/common/tolerances.h"
#include "meanvalue/decode/fast/fast_solve.h"
#include "meanvalue/optimise/elimination_order.h"

namespace meanvalue {
namespace {

// Free vertices of the coarse level: enough for the shape of limbs, few enough for hundreds of steps a second. Where
// there are not twice as many, it is not worth its splits.
constexpr Index kCoarse = 1000;
// The share of the vertices in a middle level, which is made where it has four times as many as the coarse one:
// wrinkles that the coarse level is too coarse for are found there at a fifth of the cost.
constexpr double kMiddleShare = 0.2;
// The rigidity that cold solves begin with: a stiff shape finds the rotation of every limb, and a softer one keeps
// it.
constexpr double kStiff = 1000.0;
// A draft has its anchors within this share of the size from their targets, where they are put then.
constexpr double kMostLeft = 2e-3;

/// How many times as strong soft anchors are beside such factors (Binding::stiffness) as without: by as much as the
/// pull that it takes to bend the shape grows.
double strength_beside(const std::vector<double>& stiffness) {
    double product = 1.0;
    for (const double factor : stiffness)
        product *= power(factor, 0.5 / static_cast<double>(stiffness.size()));
    return product;
}

}  // namespace

FastDecoder::FastDecoder(EncodedRegion shape, std::vector<SoftAnchor> soft, const std::vector<Index>& handles,
                         double rigidity, std::vector<double> stiffness, int threads, Execution& execution)
    : Decoder(shape, threads), problem_{rest_, is_fixed_, is_fixed_, rigidity, shape_->size, std::move(soft)} {
    const double stronger = problem_.soft.empty() ? 1.0 : strength_beside(stiffness);
    for (SoftAnchor& anchor : problem_.soft)
        anchor.strength *= stronger;
    problem_.stiffness = std::move(stiffness);
    std::sort(problem_.soft.begin(), problem_.soft.end(),
              [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
    std::vector<char> is_soft(problem_.soft.empty() ? 0 : is_fixed_.size(), 0);
    if (!problem_.soft.empty()) problem_.carrying.assign(is_fixed_.size(), 1.0);
    for (const SoftAnchor& anchor : problem_.soft) {
        is_soft[anchor.vertex] = problem_.is_anchor[anchor.vertex] = 1;
        problem_.carrying[anchor.vertex] = hardness_of(anchor.strength);
    }
    problem_.handles = std::make_shared<HandlePaths>(encoding_, rest_, problem_.is_anchor, handles, problem_.size);
    unknowns_ = find_unknowns(encoding_, is_fixed_);
    cells_ = rest_cells(encoding_, rest_, threads_, execution);
    if (!problem_.soft.empty()) unit_ = energy_unit(encoding_, unknowns_, cells_);
    const auto free_count = static_cast<double>(unknowns_.free.size());
    if (free_count <= 2.0 * kCoarse) return;
    coarsen(handles, std::move(is_soft), free_count, execution);
    const StageTimer timer(bind_timings_, "coarse level");
    problem_.levels = {make_coarse_level(problem_.hierarchy->base(), from_stiff(), execution)};
}

FastDecoder::FastDecoder(EncodedRegion shape, FastProblem whole, int threads)
    : Decoder(shape, threads), problem_(std::move(whole)) {}

std::unique_ptr<const Decoder> FastDecoder::early() const {
    if (problem_.levels.empty()) return nullptr;
    return std::unique_ptr<const Decoder>(new FastDecoder({shape_, is_fixed_, instructions_}, problem_, threads_));
}

void FastDecoder::finish(Execution& execution) {
    find_order(threads_, execution);
    const std::vector<double> rigidities =
        problem_.levels.empty() ? from_stiff() : std::vector<double>{problem_.rigidity};
    {
        const StageTimer timer(bind_timings_, "factor");
        execution.begin_stage("factor");
        problem_.levels.insert(problem_.levels.begin(), make_level(encoding_, std::move(cells_), std::move(unknowns_),
                                                                   problem_.soft, rigidities, threads_, execution));
    }
    const FastLevel& whole = *problem_.levels.front();
    if (!whole.stages.empty()) {
        std::vector<Index> vertices = whole.stages.back().coupling.vertices;
        const std::vector<Index>& soft = whole.energy->soft_constraints().vertices();
        vertices.insert(vertices.end(), soft.begin(), soft.end());
        problem_.driving =
            std::make_shared<DrivingHandles>(rest_(vertices, Eigen::all), problem_.handles->pieces_of(vertices));
    }
    // Behind the whole mesh's, whose numbers take the most memory.
    for (std::size_t middle = 0; middle + 1 < problem_.hierarchy->levels.size(); ++middle) {
        const StageTimer timer(bind_timings_, "coarse level");
        problem_.levels.insert(problem_.levels.end() - 1,
                               make_coarse_level(problem_.hierarchy->levels[middle], rigidities, execution));
    }
}

std::vector<double> FastDecoder::from_stiff() const {
    if (kStiff > problem_.rigidity) return {kStiff, problem_.rigidity};
    return {problem_.rigidity};
}

void FastDecoder::coarsen(const std::vector<Index>& handles, std::vector<char> is_soft, double free_count,
                          Execution& execution) {
    const StageTimer timer(bind_timings_, "hierarchy");
    CoarseningOptions options;
    if (kMiddleShare * free_count > 4.0 * kCoarse)
        options.level_sizes.push_back(static_cast<Index>(kMiddleShare * free_count));
    options.level_sizes.push_back(kCoarse);
    options.down_to_base = false;
    options.thin_out_fixed = true;
    options.handles = handles;
    options.is_soft = std::move(is_soft);
    problem_.hierarchy = std::make_shared<const Hierarchy>(
        build_hierarchy(shape_->rings, rest_, is_fixed_, options, threads_, execution));
}

std::shared_ptr<const FastLevel> FastDecoder::make_coarse_level(const Level& level,
                                                                const std::vector<double>& rigidities,
                                                                Execution& execution) const {
    RestCells cells = rest_cells(level.encoding, rest_, threads_, execution);
    std::vector<char> is_fixed = is_fixed_;
    for (std::size_t k = 0; k < level.removed_count; ++k)
        is_fixed[problem_.hierarchy->order[k]] = 1;
    Unknowns remaining = find_unknowns(level.encoding, is_fixed);
    std::vector<SoftAnchor> soft;
    if (!problem_.soft.empty()) {
        const double scale = energy_unit(level.encoding, remaining, cells) / unit_;
        soft = coarse_soft_anchors(problem_.soft, *problem_.hierarchy, level, is_fixed_.size(), scale);
    }
    return make_level(level.encoding, std::move(cells), std::move(remaining), std::move(soft), rigidities, threads_,
                      execution);
}

std::shared_ptr<const FastLevel> FastDecoder::make_level(const Encoding& encoding, RestCells cells, Unknowns unknowns,
                                                         std::vector<SoftAnchor> soft,
                                                         const std::vector<double>& rigidities, int threads,
                                                         Execution& execution) const {
    const bool is_whole = &encoding == &encoding_;
    auto level = std::make_shared<FastLevel>();
    level->encoding = &encoding;
    if (shape_->examples) {
        level->examples = is_whole
                              ? std::shared_ptr<const ExampleSpace>(shape_, &shape_->examples->whole)
                              : std::make_shared<const ExampleSpace>(encoding, shape_->examples->functions, rest_,
                                                                     shape_->examples->shapes, threads, execution);
    }
    level->unknowns = std::move(unknowns);
    level->energy = std::make_unique<DeformationEnergy>(
        encoding, level->unknowns, cells, problem_.size, DeformationEnergy::weights_for(problem_.rigidity), execution,
        instructions_, SoftConstraints(std::move(soft), level->unknowns), threads, problem_.stiffness);
    cells = {};  // they are large, and what follows takes the most memory
    if (level->unknowns.free.empty()) return level;
    for (const double rigidity : rigidities) {
        InitialHessian initial = level->energy->initial_hessian(rigidity, threads, execution);
        SparseMatrix& hessian = initial.matrix;
        // Positive definite also where anchors leave something open. A share of each entry, not of the mean, which a
        // single small star of triangles may raise far above all others.
        for (Eigen::Index k = 0; k < hessian.cols(); ++k) {
            double& diagonal = hessian.valuePtr()[hessian.outerIndexPtr()[k]];
            diagonal = diagonal > 0.0 ? diagonal * (1.0 + kNegligible) : 1.0;  // no row reaches this vertex
        }
        FastStage stage;
        stage.rigidity = rigidity;
        stage.coupling = std::move(initial.coupling);
        if (level->stages.empty()) {
            stage.factor = SupernodalFactor(instructions_);
            stage.factor.analyse(
                hessian, execution, threads,
                is_whole ? numbers_in_order(*elimination_order_, level->unknowns) : std::vector<Index>());
        } else {
            stage.factor = level->stages.front().factor.with_same_pattern();  // it does not depend on rigidity
        }
        if (!stage.factor.factorise(hessian, execution, threads)) {
            throw SolverFailure(message("the system of ", level->unknowns.free.size(), " free vertices is singular"));
        }
        level->stages.push_back(std::move(stage));
    }
    return level;
}

std::unique_ptr<Workspace> FastDecoder::make_workspace(const Execution& execution) const {
    auto workspace = std::make_unique<FastWorkspace>();
    for (const auto& level : problem_.levels) {
        execution.check();
        workspace->levels.emplace_back();
        FastWorkspace::OfLevel& of_level = workspace->levels.back();
        of_level.energy = level->energy->make_workspace();
        of_level.minimiser = Lbfgs(level->unknowns, problem_.size);
        of_level.downdates.resize(level->stages.size());
    }
    workspace->predictor = SecantPredictor(problem_.size);
    if (problem_.driving) workspace->responses = HandleResponses(*problem_.driving);
    return workspace;
}

DecodeReport FastDecoder::decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                                 Execution& execution) const {
    auto& fast_workspace = static_cast<FastWorkspace&>(workspace);
    const std::vector<Level>& coarse = problem_.hierarchy->levels;
    const std::size_t unbound = coarse.size() + 1 - problem_.levels.size();  // the finest ones, of an early decoder
    DecodeOptions own_options = options;
    own_options.in_drag = options.in_drag && unbound == 0;  // a drag's memory is of the whole mesh
    DecodeReport report =
        FastSolve(problem_, fast_workspace, own_options, threads_for(options), execution).run(positions);
    const StageTimer timer(report.timings, "split");
    for (std::size_t level = unbound; level-- > 0;)
        coarse[level].splits.carry(rest_, positions, threads_for(options), execution);
    return report;
}

void FastDecoder::remember(const Positions& answer, Workspace& workspace) const {
    auto& work = static_cast<FastWorkspace&>(workspace);
    // Nothing is free; an early one: a drag's memory is of the whole mesh; or it began from rest, and knows nothing.
    if (!problem_.driving || work.predictor.shape().rows() == 0) return;
    const DeformationEnergy::Workspace& energy = work.levels.front().energy;
    const std::lock_guard<std::mutex> lock(work.drafting);
    work.predictor.note(answer, drivers_of(*problem_.levels.front(), answer, energy.soft_targets));
    work.is_drafting = energy.soft_weights.empty();
    work.keeps_history = true;
}

bool FastDecoder::draft(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                        const Execution& execution) const {
    auto& work = static_cast<FastWorkspace&>(workspace);
    if (problem_.levels.front()->unknowns.free.empty()) return true;
    const std::lock_guard<std::mutex> lock(work.drafting);
    if (!work.is_drafting || !work.predictor.is_good()) return false;
    const FastLevel& level = *problem_.levels.front();
    const int threads = threads_for(options);
    const Positions goal =
        drivers_of(level, positions, level.energy->soft_constraints().targets_of(*options.targets));
    positions = work.predictor.shape();
    Positions left = goal - work.predictor.predict(goal, positions, threads, execution);
    work.responses.answer(left, level.unknowns, positions, threads, execution);
    return left.size() == 0 || left.cwiseAbs().maxCoeff() <= kMostLeft * problem_.size;
}

std::vector<Index> FastDecoder::level_sizes() const {
    std::vector<Index> sizes;
    sizes.reserve(problem_.levels.size());
    for (const auto& level : problem_.levels)
        sizes.push_back(static_cast<Index>(level->unknowns.free.size()));
    return sizes;
}

Index FastDecoder::longest_ring() const {
    const Index longest = encoding_.longest_ring();
    return problem_.hierarchy->levels.empty() ? longest : std::max(longest, problem_.hierarchy->longest_ring());
}

std::size_t FastDecoder::bytes() const {
    constexpr std::size_t kEachFree = 2250;
    constexpr std::size_t kBlended = 1200;
    constexpr std::size_t kEachExample = 150;
    std::size_t each_free = kEachFree;
    if (shape_->examples) each_free += kBlended + kEachExample * shape_->examples->shapes.size();
    std::size_t sum = each_free * problem_.levels.front()->unknowns.free.size();
    for (const auto& level : problem_.levels) {
        for (const FastStage& stage : level->stages)
            sum += stage.factor.bytes();
    }
    return sum;
}

}  // namespace meanvalue
