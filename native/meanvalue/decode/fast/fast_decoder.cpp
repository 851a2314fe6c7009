#include "meanvalue/decode/fast/fast_decoder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "meanvalue/common/errors.h"
#include "meanvalue/decode/fast/fast_solve.h"
#include "meanvalue/optimise/elimination_order.h"

namespace meanvalue {
namespace {

// Free vertices of the coarse level: enough for the shape of limbs, few enough for hundreds of steps a second.
constexpr double kCoarseShare = 0.03;
constexpr double kFewestCoarse = 1000;
constexpr double kMostCoarse = 4000;
constexpr Index kTooManyCoarse = 8000;
// Of a level in between, where it has at least so many times the vertices of the coarse one: wrinkles that the coarse
// level is too coarse for are found there at a fifth of the cost.
constexpr double kMiddleShare = 0.2;
constexpr double kMiddleOverCoarse = 3.0;
// Below this a coarse level is not worth its splits.
constexpr std::size_t kSmallMesh = 2000;
// Cold solves begin stiff: a stiff shape finds the right turn of every limb, and softer ones keep it.
constexpr double kStiffness[] = {1000.0, 300.0, 100.0};
// On the diagonal of the constant matrices, as a share of itself: keeps them positive definite where anchors leave
// something open. Not of the mean, which a single small star of triangles may raise far above all others.
constexpr double kLeastDiagonal = 1e-9;

}  // namespace

FastDecoder::FastDecoder(EncodedRegion shape, std::vector<SoftAnchor> soft, const std::vector<Index>& handles,
                         double rigidity, int threads, Execution& execution)
    : Decoder(shape, threads), rigidity_(rigidity), size_(shape_->size), soft_(std::move(soft)) {
    std::sort(soft_.begin(), soft_.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
    std::vector<char> is_soft(soft_.empty() ? 0 : region_.is_fixed.size(), 0);
    std::vector<char> is_held = region_.is_fixed;
    if (!soft_.empty()) hold_.assign(region_.is_fixed.size(), 1.0);
    for (const SoftAnchor& anchor : soft_) {
        is_soft[anchor.vertex] = is_held[anchor.vertex] = 1;
        hold_[anchor.vertex] = hardness_of(anchor.strength);
    }
    pieces_ = std::make_unique<HandlePaths>(encoding_, region_.positions, is_held, handles, size_, execution);
    std::vector<double> stages;
    for (const double stiffness : kStiffness) {
        if (stiffness > rigidity_) stages.push_back(stiffness);
    }
    stages.push_back(rigidity_);
    Unknowns unknowns = find_unknowns(encoding_, region_.is_fixed);
    const RestCells fine_cells = rest_cells(encoding_, region_.positions, threads_, execution);
    std::unique_ptr<FastLevel> coarse;
    if (unknowns.free.size() > kSmallMesh) {
        {
            const StageTimer timer(bind_timings_, "hierarchy");
            CoarseningOptions options;
            const auto count = static_cast<double>(unknowns.free.size());
            const double coarse_count = std::clamp(kCoarseShare * count, kFewestCoarse, kMostCoarse);
            if (kMiddleShare * count > kMiddleOverCoarse * coarse_count)
                options.level_sizes.push_back(static_cast<Index>(kMiddleShare * count));
            options.level_sizes.push_back(static_cast<Index>(coarse_count));
            options.down_to_base = false;
            options.exact_order = false;
            options.thin_out_fixed = true;
            options.handles = handles;
            options.is_soft = std::move(is_soft);
            hierarchy_ =
                build_hierarchy(shape_->rings, region_.positions, region_.is_fixed, options, SplitBy::kCarrying,
                                threads_, execution, shape.earlier_removals.get(), &removals_);
        }
        const StageTimer timer(bind_timings_, "coarse level");
        const auto make = [&](const Level& level) {
            const RestCells cells = rest_cells(level.encoding, region_.positions, threads_, execution);
            std::vector<char> is_fixed = region_.is_fixed;
            for (std::size_t k = 0; k < level.removed_count; ++k)
                is_fixed[hierarchy_.order[k]] = 1;
            Unknowns remaining = find_unknowns(level.encoding, is_fixed);
            std::vector<SoftAnchor> soft;
            if (!soft_.empty()) {
                const double scale = energy_unit(level.encoding, remaining, cells, execution) /
                                     energy_unit(encoding_, unknowns, fine_cells, execution);
                soft = coarse_soft_anchors(soft_, hierarchy_, level, region_.is_fixed.size(), scale);
            }
            return make_level(level.encoding, cells, std::move(remaining), std::move(soft), stages, false, execution);
        };
        // A level that could not be made coarse is factored twice and not four times.
        if (hierarchy_.base().free_count > kTooManyCoarse && stages.size() > 2)
            stages = {stages.front(), stages.back()};
        coarse = make(hierarchy_.base());
        stages = {rigidity_};
        if (hierarchy_.levels.size() > 1) middle_ = make(hierarchy_.levels.front());
    }
    const StageTimer timer(bind_timings_, "factor");
    execution.begin_stage("factor");
    std::unique_ptr<FastLevel> fine =
        make_level(encoding_, fine_cells, std::move(unknowns), soft_, stages, true, execution);
    const auto couple_fixed = [&](const FastLevel& level, FastStage& stage) {
        stage.coupling = level.energy->fixed_coupling(stage.rigidity, execution);
    };
    if (!fine->stages.empty()) couple_fixed(*fine, fine->stages.back());
    FastLevel& starting = coarse ? *coarse : *fine;
    if (!starting.stages.empty()) couple_fixed(starting, starting.stages.front());
    fine_ = std::move(fine);
    coarse_ = std::move(coarse);
}

std::unique_ptr<FastLevel> FastDecoder::make_level(const Encoding& encoding, const RestCells& cells,
                                                   Unknowns unknowns, std::vector<SoftAnchor> soft,
                                                   const std::vector<double>& rigidities, bool is_whole,
                                                   Execution& execution) const {
    auto level = std::make_unique<FastLevel>();
    level->unknowns = std::move(unknowns);
    level->energy = std::make_unique<DeformationEnergy>(
        encoding, level->unknowns, cells, size_, DeformationEnergy::weights_for(rigidity_), execution,
        instructions_ == InstructionSet::kFastest ? DeformationEnergy::Kernel::kFastest
                                                  : DeformationEnergy::Kernel::kPortable,
        SoftConstraints(std::move(soft), level->unknowns),
        &encoding == &shape_->encoding && shape_->stiff_rings ? &*shape_->stiff_rings : nullptr);
    if (level->unknowns.free.empty()) return level;
    for (const double rigidity : rigidities) {
        SparseMatrix hessian = level->energy->constant_hessian(rigidity, threads_, execution);
        for (Eigen::Index k = 0; k < hessian.cols(); ++k) {
            double& diagonal = hessian.valuePtr()[hessian.outerIndexPtr()[k]];
            diagonal = diagonal > 0.0 ? diagonal * (1.0 + kLeastDiagonal) : 1.0;  // no row reaches this vertex
        }
        FastStage stage;
        stage.rigidity = rigidity;
        if (level->stages.empty()) {
            stage.factor = SupernodalFactor(instructions_);
            stage.factor.analyse(
                hessian, execution, threads_,
                is_whole ? slots_in_order(shape_->elimination_order, level->unknowns) : std::vector<Index>());
        } else {
            stage.factor = level->stages.front().factor.of_same_pattern();  // it does not depend on rigidity
        }
        if (!stage.factor.factorise(hessian, execution, threads_)) {
            throw SolverFailure(message("the system of ", hessian.cols(), " free vertices is singular"));
        }
        level->stages.push_back(std::move(stage));
    }
    return level;
}

std::unique_ptr<Workspace> FastDecoder::make_workspace(const Execution& execution) const {
    auto workspace = std::make_unique<FastWorkspace>();
    const auto prepare = [&](const std::unique_ptr<const FastLevel>& level, FastWorkspace::OfLevel& of_level) {
        if (!level) return;
        execution.check();
        of_level.energy = level->energy->make_workspace();
        of_level.minimiser = Lbfgs(level->unknowns, size_, instructions_);
        of_level.downdates.resize(level->stages.size());
    };
    prepare(fine_, workspace->fine);
    prepare(coarse_, workspace->coarse);
    prepare(middle_, workspace->middle);
    workspace->predictor = SecantPredictor(size_);
    const std::size_t drivers =
        soft_.size() + (fine_->stages.empty() ? 0 : fine_->stages.back().coupling.vertices.size());
    workspace->later_bytes = SecantPredictor::bytes(region_.is_fixed.size(), drivers);
    if (!fine_->stages.empty()) workspace->later_bytes += fine_->stages.back().factor.workspace_bytes();
    return workspace;
}

DecodeReport FastDecoder::decode(const DecodeOptions& options, Workspace& workspace, Positions& positions,
                                 Execution& execution) const {
    return FastSolve(*this, static_cast<FastWorkspace&>(workspace), options, execution).run(positions);
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
    std::size_t sum = shape_->bytes() + (coarse_ ? hierarchy_.bytes() + removals_->bytes() : 0);
    for (const FastLevel* level : {fine_.get(), middle_.get(), coarse_.get()}) {
        if (level == nullptr) continue;
        sum += level->energy->bytes();
        for (const auto& stage : level->stages)
            sum += stage.factor.bytes() + stage.coupling.bytes();
    }
    return sum;
}

std::size_t FastWorkspace::bytes() const {
    std::size_t sum = later_bytes;
    for (const OfLevel* level : {&fine, &coarse, &middle}) {
        sum += level->energy.bytes() + level->minimiser.bytes();
        for (const DiagonalDowndate& downdate : level->downdates)
            sum += downdate.bytes();
    }
    return sum;
}

}  // namespace meanvalue
